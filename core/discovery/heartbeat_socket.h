// The socket by which heartbeats go and come on one link. It is read when discovery is looked after, and
// wakes no thread meanwhile.
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
  /// Nothing if the system refuses it: then heartbeats go by Cyclone.
  static std::optional<HeartbeatSocket> open(const Place& place) noexcept;

  /// A heartbeat that cannot be sent is lost, like one that gets lost on its way.
  void send(const Heartbeat& heartbeat) const noexcept;

  /// More than these are left for the next time: whoever floods the port must not hold the caller up.
  static constexpr std::size_t taken_at_once_max = 2048;
  /// Calls hear(heartbeat, age, from) for each one that has come since the last call, with the time for which
  /// it has waited in the socket, and the address of its sender. Other datagrams are dropped.
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
  /// One octet more than a heartbeat: longer datagrams are none.
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
