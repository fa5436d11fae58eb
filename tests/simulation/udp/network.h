// A simulated network between two hosts. A seed determines the datagrams that the network loses, delays,
// swaps and repeats. The network delivers no datagrams while the hosts are parted.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <utility>

#include "tests/simulation/udp/random.h"
#include "tests/unit/udp/mutations.h"

namespace sft::simulation {

struct Weather {
  double loss = 0;
  double repetition = 0;
  std::chrono::microseconds delay{50};
  /// The longest additional delay of some datagrams, which later datagrams therefore overtake.
  std::chrono::microseconds jitter{0};
  Time parted_from{}, parted_until{};
  double forged = 0;  ///< the share of the datagrams of which a mutated copy arrives, too
  Time forged_until{};
};

class Network {
 public:
  enum class Side : std::uint8_t { writer, reader };
  struct Datagram {
    Side to{};
    Bytes bytes;
  };

  /// `datagram_bytes` is the length of the longest datagrams that the path carries. `random` must outlive the
  /// network.
  Network(const Weather& weather, std::size_t datagram_bytes, Random& random)
      : weather_(weather), datagram_bytes_(datagram_bytes), random_(random) {}

  std::size_t datagram_bytes() const { return datagram_bytes_; }
  /// Sends datagrams by another path from now on. That path carries datagrams up to the given length.
  void take_detour(std::size_t datagram_bytes) { datagram_bytes_ = datagram_bytes; }

  void send(Side to, Bytes bytes, Time now) {
    if (now >= weather_.parted_from && now < weather_.parted_until) return;
    if (happens(random_, weather_.loss)) return;
    if (happens(random_, weather_.repetition)) deliver_later({to, bytes}, now);
    if (now < weather_.forged_until && happens(random_, weather_.forged)) {
      Bytes copy = bytes;
      udp::test::mutate(copy, random_);
      deliver_later({to, std::move(copy)}, now);
    }
    deliver_later({to, std::move(bytes)}, now);
  }

  /// Returns the time at which the next datagram arrives.
  Time next() const { return under_way_.empty() ? Time::max() : under_way_.begin()->first; }
  Datagram take() { return std::move(under_way_.extract(under_way_.begin()).mapped()); }

 private:
  void deliver_later(Datagram datagram, Time now) {
    auto delay = weather_.delay;
    if (happens(random_, 0.1))
      delay +=
          std::chrono::microseconds(from_to(random_, 0, static_cast<std::uint64_t>(weather_.jitter.count())));
    under_way_.emplace(now + delay, std::move(datagram));
  }

  const Weather weather_;
  std::size_t datagram_bytes_;
  Random& random_;
  std::multimap<Time, Datagram> under_way_;
};

}  // namespace sft::simulation
