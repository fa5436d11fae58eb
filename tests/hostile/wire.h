// Datagrams of an attacker's host: sending them, sending them in another host's name, and overhearing them.
#pragma once

#include <netinet/in.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/control/control.h"
#include "udp_transport/wire/datagram.h"

namespace sft::hostile {

using Bytes = std::vector<std::byte>;

/// A sequence that no honest writer reaches.
inline constexpr std::uint64_t far_future = std::uint64_t{1} << 62;

/// Returns an address of this host as an endpoint announces it.
core::UdpAddress own_address(std::uint16_t port);

/// Returns the address in network byte order. The hosts of these tests have only IPv4.
sockaddr_in to_sockaddr(const core::UdpAddress& address);
/// Returns the addresses at which an endpoint receives; empty if it announces none.
std::vector<sockaddr_in> addresses_of(const core::Endpoint& endpoint);

sockaddr_in to_port(std::uint32_t address, std::uint16_t port);

/// Returns a datagram that consists of this header only.
template <class Header>
Bytes encoded(const Header& header, std::size_t bytes) {
  Bytes datagram(bytes);
  udp::encode(header, datagram.data());
  return datagram;
}

/// A socket of this host.
class Sender {
 public:
  Sender();
  ~Sender();
  Sender(const Sender&) = delete;
  Sender& operator=(const Sender&) = delete;
  void send(std::span<const std::byte> datagram, const sockaddr_in& to) const;
  std::uint16_t port() const;

 private:
  int socket_;
};

/// Sends datagrams with a forged source address. Needs CAP_NET_RAW.
class Spoofer {
 public:
  Spoofer();
  ~Spoofer();
  Spoofer(const Spoofer&) = delete;
  Spoofer& operator=(const Spoofer&) = delete;
  void send(std::span<const std::byte> payload, const sockaddr_in& from, const sockaddr_in& to) const;

 private:
  int socket_;
};

/// A socket that counts bytes and never answers.
class Drain {
 public:
  Drain();
  ~Drain();
  Drain(const Drain&) = delete;
  Drain& operator=(const Drain&) = delete;
  std::uint16_t port() const { return port_; }
  /// Returns the number of bytes that have come so far.
  std::uint64_t count();

 private:
  int socket_;
  std::uint16_t port_ = 0;
  std::uint64_t bytes_ = 0;
};

struct Overheard {
  sockaddr_in from{};
  sockaddr_in to{};
  Bytes payload{};
};

/// Receives datagrams between other hosts, as on a network without switches. It keeps only those that look
/// like datagrams of SFT: samples and their answers, or messages of the control plane.
class Listener {
 public:
  enum class Traffic : std::uint8_t { data, control };
  explicit Listener(Traffic traffic = Traffic::data);
  ~Listener();
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;
  /// Returns the datagrams that came since the last call.
  std::vector<Overheard> listen();

 private:
  const Traffic traffic_;
  int socket_;
};

}  // namespace sft::hostile
