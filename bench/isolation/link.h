// The link of the remote reader's host, which can become bad.
#pragma once

#include <cstddef>
#include <memory>

#include "tools/hosts/network.h"

namespace sft::bench::isolation {

inline constexpr int lossy_percent = 20;
inline constexpr int narrow_mbit_s = 50;

/// Ends the program with a message where the system cannot do what is asked for.
class Link {
 public:
  Link(std::shared_ptr<const hosts::EmulatedNetwork> network, std::size_t host)
      : network_(std::move(network)), host_(host) {}

  /// The host loses `lossy_percent` of the packets that arrive, each by chance (nftables).
  void make_lossy() const;
  /// The switch passes no more than `narrow_mbit_s` on to the host. It queues 50 ms of it, and drops the rest
  /// (the token bucket filter of tc).
  void make_narrow() const;
  // These functions end that.
  void lose_nothing() const;
  void widen() const;

 private:
  const std::shared_ptr<const hosts::EmulatedNetwork> network_;
  const std::size_t host_;
};

}  // namespace sft::bench::isolation
