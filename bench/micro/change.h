// Whether a figure has changed by more than the noise within two runs. Pure.
//
// A figure is the median of the ratios of its repetitions. Around each median is an interval, between two of
// the sorted ratios, that contains the true median in 99 % of cases (the sign test): nothing is assumed about
// how noise is distributed. A figure has changed if the intervals of both runs have nothing in common and the
// medians differ by more than `change_min`. The noise between runs of the same program can be larger than
// that, which this does not see.
#pragma once

#include <iosfwd>
#include <map>
#include <string>
#include <vector>

namespace sft::bench::micro {

inline constexpr double change_min = 0.05;

/// The ratios of each figure, by repetition.
using Ratios = std::map<std::string, std::vector<double>>;

struct Interval {
  double low = 0;
  double middle = 0;
  double high = 0;
};

/// REQUIRES: there are ratios. The interval is that of all ratios where there are fewer than eight.
Interval interval_of(std::vector<double> ratios);

enum class Verdict { slower, faster, same, only_before, only_now };

struct Change {
  std::string name;
  Interval before{};
  Interval now{};
  Verdict verdict{};
};

/// A change for each figure of either run, in the order of their names.
std::vector<Change> compare(const Ratios& before, const Ratios& now);

/// A line for each change, and a sentence that counts them.
std::string text_of(const std::vector<Change>& changes);

// The form of a file that keeps the ratios of a run.
void write(std::ostream& out, const Ratios& ratios);
/// Empty if the text is not of that form.
Ratios read(std::istream& in);

}  // namespace sft::bench::micro
