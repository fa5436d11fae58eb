// The socket that sends and receives the heartbeats of one link. Discovery::look_after() reads it; it wakes
// no thread.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>

#include "core/discovery/heartbeat.h"
#include "core/platform/file_descriptor.h"
#include "core/platform/ip_address.h"

namespace sft::core {

class HeartbeatSocket {
 public:
  struct Place {
    IpAddress ip;        ///< of the link; IPv4
    unsigned index = 0;  ///< of its interface
    std::uint16_t port = 0;
    bool reaches_own_host = false;
  };
  /// Returns nothing if the system refuses the socket. Heartbeats go by Cyclone then.
  static std::optional<HeartbeatSocket> open(const Place& place) noexcept;

  /// A heartbeat that cannot be sent is lost, like one that gets lost on its way.
  void send(const Heartbeat& heartbeat) const noexcept;

  /// One call reads no more datagrams than these, so that a flood at the port does not hold the caller up.
  static constexpr std::size_t taken_at_once_max = 2048;
  /// Calls hear(heartbeat, age, from) for each heartbeat that has come since the last call, with the time for
  /// which it has waited in the socket, and the address of its sender. Other datagrams are dropped.
  template <class Hear>
  void take(Hear hear) {
    for (std::size_t taken = 0; taken < taken_at_once_max;) {
      const std::size_t came = receive();
      for (std::size_t i = 0; i < came; ++i) {
        if (const auto heartbeat = decode_heartbeat(received(i))) hear(*heartbeat, ages_[i], senders_[i]);
      }
      if (came < batch) return;
      taken += came;
    }
  }

 private:
  static constexpr std::size_t batch = 32;
  /// One octet more than a heartbeat, so that longer datagrams are recognized.
  using Buffer = std::array<std::byte, heartbeat_bytes + 1>;

  HeartbeatSocket(FileDescriptor socket, std::uint16_t port) : socket_(std::move(socket)), port_(port) {}
  std::size_t receive() noexcept;
  std::span<const std::byte> received(std::size_t i) const { return {buffers_[i].data(), sizes_[i]}; }

  FileDescriptor socket_;
  std::uint16_t port_ = 0;
  std::array<Buffer, batch> buffers_{};
  std::array<std::size_t, batch> sizes_{};
  std::array<std::chrono::nanoseconds, batch> ages_{};
  std::array<IpAddress, batch> senders_{};
};

}  // namespace sft::core
