// The numbers of samples: which samples arrived, in which order, and to which sample an answer belongs.
#pragma once

#include <cstdint>
#include <vector>

namespace sft::perf {

/// A part of the answers of one side. Answers have their own numbers, since lost samples are not answered.
/// The answers from number `answer` up to the next part belong to consecutive samples, from number `sample`
/// on.
struct Part {
  std::uint64_t answer = 1;
  std::uint64_t sample = 1;
  friend bool operator==(const Part&, const Part&) = default;
};

/// Records on the answering side to which samples its answers belong.
class Answered {
 public:
  /// Notes that the next answer belongs to this sample.
  void note(std::uint64_t sample);
  std::uint64_t count() const { return count_; }
  /// Returns the parts that began since the last call.
  std::vector<Part> take_parts();

 private:
  std::uint64_t count_ = 0;
  std::uint64_t expected_ = 0;
  std::vector<Part> parts_;
};

/// Returns the number of the sample that an answer belongs to; 0: it is not known.
std::uint64_t sample_of(std::uint64_t answer, const std::vector<Part>& parts);

/// Counts samples by their numbers, from 1.
class Tally {
 public:
  /// Returns false if the sample has come before.
  bool note(std::uint64_t number);
  std::uint64_t distinct() const { return distinct_; }
  /// Samples that arrived after a sample with a higher number
  std::uint64_t reordered() const { return reordered_; }
  std::uint64_t twice() const { return twice_; }

 private:
  std::vector<bool> came_;
  std::uint64_t distinct_ = 0, reordered_ = 0, twice_ = 0, highest_ = 0;
};

/// Returns the time from which the latency of a sample is counted. This is the time at which it was sent.
/// If the program stalled and sent it late, it is the time at which it was due. Otherwise a stall that
/// delays many samples would be visible in only one of them. `is_late` is set to true in the second case.
std::int64_t counted_from(std::int64_t due_ns, std::int64_t sent_ns, std::int64_t period_ns, bool& is_late);

}  // namespace sft::perf
