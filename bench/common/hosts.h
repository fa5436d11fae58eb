// Hosts that are joined by a network, for one benchmark.
#pragma once

#include <functional>

#include "bench/common/pair.h"
#include "tools/hosts/network.h"

namespace sft::bench {

/// The way in which interfaces of hosts send a train of datagrams that one system call hands over.
enum class Trains {
  cut,   ///< trains are cut into frames, each of which is counted with its headers
  whole  ///< trains are passed on in one piece, as fast as the system can
};

/// Makes hosts that are joined by a network. Ends the program with a message if it does not run as root.
hosts::EmulatedNetwork make_hosts(std::size_t hosts, Trains trains);

/// Returns the address of a host as a number in network byte order.
std::uint32_t address_of(std::size_t host);

class TwoHosts {
 public:
  explicit TwoHosts(Trains trains = Trains::cut);

  /// Returns the two sides of a pair: the sender runs on the first host, the receiver on the second.
  Sides sides(std::function<void(Exchange&)> sender, std::function<void(Exchange&)> receiver) const;
  /// Moves the calling process to the first host or to the second.
  void enter(std::size_t host) const;

 private:
  hosts::EmulatedNetwork network_;
};

/// The bytes that eth0 of the calling process's host has received and sent, with link-layer headers.
struct LinkBytes {
  std::int64_t received = 0;
  std::int64_t sent = 0;
};
LinkBytes link_bytes();

}  // namespace sft::bench
