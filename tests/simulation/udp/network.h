// A network and a clock in memory: datagrams get lost, delayed, swapped and repeated as a seed says, and
// nothing passes while it is parted.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <random>
#include <span>
#include <utility>
#include <vector>

#include "tests/unit/udp/mutations.h"

namespace sft::simulation {

using Time = std::chrono::steady_clock::time_point;
using Random = std::mt19937_64;
using Bytes = std::vector<std::byte>;

inline bool happens(Random& random, double probability) {
  return std::uniform_real_distribution<>()(random) < probability;
}
inline std::uint64_t from_to(Random& random, std::uint64_t least, std::uint64_t most) {
  return std::uniform_int_distribution<std::uint64_t>(least, most)(random);
}

struct Weather {
  double loss = 0;
  double repetition = 0;
  std::chrono::microseconds delay{50};
  std::chrono::microseconds jitter{0};  ///< at most, of some: then others overtake
  Time parted_from{}, parted_until{};
  double forged = 0;  ///< share of which a mutated copy comes as well
  Time forged_until{};
};

class Network {
 public:
  enum class Side : std::uint8_t { writer, reader };
  struct Datagram {
    Side to{};
    Bytes bytes;
  };

  Network(const Weather& weather, Random& random) : weather_(weather), random_(random) {}

  void send(Side to, Bytes bytes, Time now) {
    ++sent_;
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
  Time next() const { return under_way_.empty() ? Time::max() : under_way_.begin()->first; }
  Datagram take() { return std::move(under_way_.extract(under_way_.begin()).mapped()); }
  std::uint64_t sent() const { return sent_; }

 private:
  void deliver_later(Datagram datagram, Time now) {
    auto delay = weather_.delay;
    if (happens(random_, 0.1))
      delay +=
          std::chrono::microseconds(from_to(random_, 0, static_cast<std::uint64_t>(weather_.jitter.count())));
    under_way_.emplace(now + delay, std::move(datagram));
  }

  const Weather weather_;
  Random& random_;
  std::multimap<Time, Datagram> under_way_;
  std::uint64_t sent_ = 0;
};

}  // namespace sft::simulation
