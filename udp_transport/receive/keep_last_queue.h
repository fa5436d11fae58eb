// Samples of one writer that wait to be taken: at most `depth`, in the order of their sequences, none twice.
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/seam/sample_buffer.h"

namespace sft::udp {

class KeepLastQueue {
 public:
  explicit KeepLastQueue(std::size_t depth) : depth_(depth == 0 ? 1 : depth) {}

  enum class Put : std::uint8_t {
    kept,
    pushed_out,  ///< kept, and `sample` is now the oldest, which had to go for it
    late,        ///< older than one that was taken or pushed out already
    repeated,
  };
  /// `arrival` counts up over all writers of a reader.
  Put put(core::SampleHandle& sample, std::uint64_t arrival);

  /// Samples that were dropped since this was asked last, because their sequences turned out to be wrong.
  std::size_t take_dropped() { return std::exchange(dropped_, 0); }

  bool empty() const { return size_ == 0; }
  std::size_t size() const { return size_; }
  /// Returns the arrival of the oldest sample. REQUIRES: the queue is not empty.
  std::uint64_t arrival() const { return entries_[head_].arrival; }
  core::SampleHandle pop();

 private:
  struct Entry {
    core::SampleHandle sample;
    std::uint64_t arrival = 0;
  };
  Entry& at(std::size_t i) { return entries_[(head_ + i) % entries_.size()]; }
  std::uint64_t sequence(std::size_t i) { return at(i).sample->header().sequence; }
  void grow();
  void begin_anew(const core::SampleBuffer& sample);

  std::size_t depth_;
  std::vector<Entry> entries_;  ///< a ring, as large as was needed so far
  std::size_t head_ = 0;
  std::size_t size_ = 0;
  std::uint64_t gone_ = 0;  ///< newest sequence that was taken or pushed out
  std::uint32_t numbering_ = 0;
  std::size_t dropped_ = 0;
};

}  // namespace sft::udp
