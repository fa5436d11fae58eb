// Computes the rates of publishers, from the progress that their nodes report at irregular times.
#pragma once

#include <sft/domain.h>
#include <chrono>
#include <cstdint>
#include <map>
#include <optional>

namespace sft::tool {

class Traffic {
 public:
  using Clock = std::chrono::steady_clock;

  struct Rate {
    double samples_per_s = 0;
    double bytes_per_s = 0;  ///< bytes per second over the network; a body counts once for each reader
  };

  void note(const DomainSnapshot& domain, Clock::time_point now);
  /// Returns the rate of the publisher. Returns nothing until there have been two reports of its progress,
  /// and zero if there was no progress for a while.
  std::optional<Rate> of(std::uint64_t publisher, Clock::time_point now) const;

 private:
  struct Entry {
    DomainSnapshot::Progress latest;
    Clock::time_point changed;
    std::optional<Rate> rate;
  };
  std::map<std::uint64_t, Entry> entries_;
};

}  // namespace sft::tool
