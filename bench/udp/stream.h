// Runs a program that writes for some time, as fast as its middleware allows, and a program that counts the
// samples.
#pragma once

#include <cstdint>
#include <vector>

#include "bench/common/contender.h"
#include "bench/common/hosts.h"

namespace sft::bench {

struct Load {
  Topic topic;
  double seconds = 1;
  std::uint64_t together = 1;  ///< the number of samples that are passed to the writer at a time
};

/// The results of the runs of one contender.
class StreamRounds {
 public:
  void run(Contender contender, const Load& load, const TwoHosts& hosts);

  // The following functions return medians; NaN if all runs failed.
  double samples_per_s() const;
  double cpu_s_per_sample() const;  ///< user and system time of both processes
  /// Returns the number of samples lost in all runs.
  double lost() const;

 private:
  std::vector<double> samples_per_s_, cpu_s_per_sample_, lost_;
};

}  // namespace sft::bench
