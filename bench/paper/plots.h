// Pictures of the results, drawn by gnuplot: those of the paper.
#pragma once

#include <optional>
#include <string>

#include "bench/paper/comparison.h"
#include "bench/paper/trace.h"

namespace sft::bench::paper {

/// A directory for the pictures and for the data that they show. It is made if it is not there, and stays
/// reachable when the program moves to a host of its own, which has another /tmp.
class Plots {
 public:
  /// The error is empty if all is well.
  std::string open(const std::string& directory);
  bool is_open() const { return directory_ >= 0; }
  /// False if gnuplot failed, or is not there.
  bool draw(const Records& all, const std::optional<Trace>& trace) const;

 private:
  std::string path(const char* file) const;

  int directory_ = -1;  ///< open as long as the program runs
};

}  // namespace sft::bench::paper
