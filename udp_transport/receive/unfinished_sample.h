// One sample of which some datagrams have come. It gets a buffer when its first datagram comes. Until then,
// it keeps the payloads of the datagrams that have come (parked payloads).
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/seam/sample_buffer.h"
#include "udp_transport/receive/interval_set.h"
#include "udp_transport/wire/datagram.h"

namespace sft::udp {

class UnfinishedSample {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// Begins another sample, and reuses the memory of the former sample.
  void begin(const SampleLabel& label, Time now);

  const SampleLabel& label() const { return first_.label; }
  Time last_progress() const { return last_progress_; }

  /// Returns the sample's place in its channel; 0: it is in no channel.
  std::uint64_t place() const { return place_; }
  void set_place(std::uint64_t place) { place_ = place; }

  bool described() const { return static_cast<bool>(buffer_); }
  const FirstHeader& first() const { return first_; }
  /// Sets the header and the buffer. The buffer must be large enough for a body of first.total bytes.
  void describe(const FirstHeader& first, std::size_t body_offset, core::SampleHandle buffer);

  enum class Added : std::uint8_t {
    yes,
    beyond_body,    ///< the datagram was ignored
    too_many_gaps,  ///< the datagram was ignored, since it would have made too many gaps
  };
  /// Adds the payload to the body. REQUIRES: described() is true.
  Added add(std::uint32_t offset, std::span<const std::byte> payload, std::size_t gaps_max, Time now);
  bool whole() const { return described() && received_.covered() == first_.total; }
  core::SampleHandle take_buffer() { return std::move(buffer_); }
  const core::SampleHandle& buffer() const { return buffer_; }
  const IntervalSet& received() const { return received_; }

  /// Keeps the payload until unpark(). REQUIRES: described() is false.
  void park(std::uint32_t offset, std::span<const std::byte> payload, Time now);
  std::size_t parked_bytes() const { return parked_.size(); }
  static std::size_t bytes_to_park(std::span<const std::byte> payload) {
    return sizeof(Parked) + payload.size();
  }
  /// Adds the parked payloads to the body. If a payload could not be added, the result is the reason.
  /// Afterwards, no payload is parked.
  Added unpark(std::size_t gaps_max, Time now);

  /// Releases the sample's memory, except for small vectors.
  void clear();

 private:
  friend class UnfinishedSamples;
  struct Parked {
    std::uint32_t offset;
    std::uint32_t bytes;
  };

  std::uint64_t place_ = 0;
  FirstHeader first_;  ///< the header; only its label is set until the sample is described
  core::SampleHandle buffer_;
  std::byte* body_ = nullptr;
  IntervalSet received_;
  std::vector<std::byte> parked_;  ///< parked payloads, each after its Parked
  Time last_progress_;
  std::size_t index_ = 0;  ///< index of the sample in `UnfinishedSamples::placed_`
  UnfinishedSample* next_in_bucket_ = nullptr;
};

}  // namespace sft::udp
