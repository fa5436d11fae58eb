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

#include "core/discovery/desired_links.h"
#include "core/discovery/heartbeat.h"
#include "core/platform/file_descriptor.h"
#include "core/platform/ip_address.h"

namespace sft::core {

class HeartbeatSocket {
 public:
  /// The link must have an IPv4 address. Returns nothing if the system refuses the socket. Heartbeats are
  /// sent through Cyclone then.
  static std::optional<HeartbeatSocket> open(const LinkSpec& link, std::uint16_t port) noexcept;

  /// Sends a heartbeat. If this fails, the heartbeat is lost without an error, as it may be on the network.
  void send(const Heartbeat& heartbeat) const noexcept;

  /// The maximum number of datagrams that one call of take() reads, so that a flood at the port does not
  /// hold the caller up.
  static constexpr std::size_t taken_at_once_max = 2048;
  /// Calls hear(heartbeat, age, from) for each heartbeat that has come since the last call. `age` is the time
  /// for which the heartbeat has waited in the socket, `from` the address of its sender. Other datagrams are
  /// dropped.
  template <class Hear>
  void take(Hear hear) const {
    Received one;
    for (std::size_t taken = 0; taken < taken_at_once_max && receive(one); ++taken) {
      if (const auto heartbeat = decode_heartbeat(std::span(one.octets).first(one.size)))
        hear(*heartbeat, one.age, one.from);
    }
  }

 private:
  struct Received {
    /// Has one octet more than a heartbeat, so that longer datagrams are recognized.
    std::array<std::byte, heartbeat_bytes + 1> octets{};
    std::size_t size = 0;
    std::chrono::nanoseconds age{};
    IpAddress from{};
  };

  HeartbeatSocket(FileDescriptor socket, std::uint16_t port) : socket_(std::move(socket)), port_(port) {}
  bool receive(Received& into) const noexcept;

  FileDescriptor socket_;
  std::uint16_t port_ = 0;
};

}  // namespace sft::core
