// Samples of one writer that wait to be taken: at most `depth`, in the order of their sequences, without
// duplicates. Their bytes are limited, too, but a single sample may have any size.
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/seam/sample_buffer.h"

namespace sft::udp {

class KeepLastQueue {
 public:
  /// `bytes_max` 0: the number of bytes is not limited.
  explicit KeepLastQueue(std::size_t depth, std::uint64_t bytes_max = 0)
      : depth_(depth == 0 ? 1 : depth), bytes_max_(bytes_max) {}

  enum class Put : std::uint8_t {
    kept,
    pushed_out,  ///< the sample is kept; `sample` now holds the removed oldest sample
    late,        ///< the sample is older than a sample that was taken or displaced
    repeated,
  };
  /// Says what happens to waiting samples if their bytes exceed the limit.
  enum class Excess : bool {
    pushed_out,
    kept,  ///< samples stay, because the publisher waits for room
  };
  /// Adds the sample. `arrival` is the number of the sample, counted over all writers of the reader.
  Put put(core::SampleHandle& sample, std::uint64_t arrival, Excess excess = Excess::pushed_out);

  /// Returns the number of samples dropped since the last call in addition to those that put() returned.
  /// They had wrong sequences, or a larger new sample displaced several samples.
  std::size_t take_dropped() { return std::exchange(dropped_, 0); }

  bool empty() const { return size_ == 0; }
  std::size_t size() const { return size_; }
  std::uint64_t bytes() const { return bytes_; }  ///< the bytes of the bodies that wait
  /// Says which further samples can wait without displacing older ones.
  class Room {
   public:
    /// Takes the room for a sample of that size. Returns false if there is none.
    bool take(std::uint64_t bytes);

   private:
    friend class KeepLastQueue;
    Room(std::size_t samples, std::uint64_t bytes, bool is_empty)
        : samples_(samples), bytes_(bytes), is_empty_(is_empty) {}
    std::size_t samples_;
    std::uint64_t bytes_;
    bool is_empty_;  ///< true if the next sample may have any size
  };
  Room room() const;
  /// Returns the number `arrival` of the oldest sample. REQUIRES: the queue is not empty.
  std::uint64_t arrival() const { return entries_[head_].arrival; }
  core::SampleHandle pop();

 private:
  /// The maximum size of a ring that an empty queue keeps. So a queue of a million samples that was once
  /// full does not keep its memory, and other queues allocate nothing once they have grown.
  static constexpr std::size_t kept_entries_max = 4096;

  struct Entry {
    core::SampleHandle sample;
    std::uint64_t arrival = 0;
  };
  Entry& at(std::size_t i) { return entries_[(head_ + i) % entries_.size()]; }
  std::uint64_t sequence(std::size_t i) { return at(i).sample->header().sequence; }
  std::uint64_t bytes_of(std::size_t i) { return at(i).sample->header().body_bytes; }
  void grow();
  core::SampleHandle drop_excess_bytes();
  void begin_anew(const core::SampleBuffer& sample);

  std::size_t depth_;
  std::uint64_t bytes_max_;
  std::uint64_t bytes_ = 0;     ///< bytes of the samples that wait
  std::vector<Entry> entries_;  ///< a ring that grows as needed
  std::size_t head_ = 0;
  std::size_t size_ = 0;
  std::uint64_t gone_ = 0;  ///< the newest sequence that was taken or displaced
  std::uint32_t numbering_ = 0;
  std::size_t dropped_ = 0;
};

}  // namespace sft::udp
