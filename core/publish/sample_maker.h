// Makes the samples of one publisher: finds memory for them, and puts header, index and body there. The body
// comes from a message, from a payload that somebody else encoded, or from what the program wrote into a
// loan.
//
// The memory comes from the port to shared memory if somebody reads there, else from the heap. A small sample
// gets the memory of the sample before, if nobody has kept that.
//
// The publisher's thread calls everything. `timeout` is the time that a function may wait for memory; the
// function leaves of it what it did not need.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>

#include "core/platform/clock.h"
#include "core/publish/outlets.h"
#include "core/seam/buffer_pool.h"
#include "core/seam/sample_buffer.h"
#include "sft/detail/convert.h"
#include "sft/detail/project.h"
#include "sft/detail/untyped.h"
#include "sft/detail/walk.h"

namespace sft::core {

class SampleMaker {
 public:
  struct Product {
    EndpointId writer = 0;
    std::string topic;                  ///< for error messages
    const TypeSupport* type = nullptr;  ///< outlives this
    std::size_t max_sample_bytes = 0;
    std::function<void(const std::string& why)> refused;  ///< see PublisherCore::Spec
  };
  SampleMaker(Product product, std::shared_ptr<BufferPool> heap);

  /// False if the message could not be sent to a reader of all fields, which why_invalid() explains. Where an
  /// outlet gets all fields, encode() finds that.
  bool accepts(const Outlets& outlets, const void* message) { return outlets.whole || is_sendable(message); }
  /// A sample, or the reason why there is none: `invalid`, which why_invalid() explains, or `no_memory`.
  struct Made {
    SampleHandle sample;
    PublishStatus why_not = PublishStatus::ok;
    std::uint32_t body_bytes = 0;
  };

  /// Encodes what the outlets need of the message. If it `may_postpone`, some of the message may be copied
  /// only when somebody asks for it (SampleBuffer::postponed): the message must then live until sent() was
  /// called.
  /// REQUIRES: accepts().
  Made encode(const Outlets& outlets, const void* message, bool may_postpone,
              std::chrono::nanoseconds& timeout);
  /// The port is done with the sample that was encoded last.
  void sent(SampleBuffer& sample) noexcept {
    if (postponed_.empty()) return;
    if (sample.postponed != nullptr) sample.postponed = nullptr;  // else others may have it, and look
    postponed_.clear();
  }
  /// The reason why the last message could not be sent.
  const std::string& why_invalid() const { return why_invalid_; }

  /// The bytes of the body that convert() makes of the payload.
  Result<std::uint32_t> converted_bytes(const detail::Payload& payload) const;
  Result<Made> convert(const Outlets& outlets, const detail::Payload& payload, std::uint32_t body_bytes,
                       std::chrono::nanoseconds& timeout);

  /// Memory for a message that the program writes itself: a whole sample as encoded from the prototype, with
  /// room for the sequences that are reserved.
  Result<SampleHandle> loan(const Outlets& outlets, const void* prototype,
                            std::span<const detail::Reservation> reservations, detail::ReservedMemory memory,
                            std::chrono::nanoseconds& timeout);
  /// A loan whose sequences were shortened where they lie becomes what encoding the shorter ones would have
  /// made.
  PublishStatus close_gaps(SampleBuffer& sample) noexcept;

 private:
  static constexpr std::size_t recycled_bytes_max = 4096;  ///< that a publisher keeps for its next sample

  bool is_sendable(const void* message);
  [[gnu::cold, gnu::noinline]] PublishStatus refuse(const void* message, const FieldMask& mask);
  Error fault_of(const void* message, const FieldMask& mask,
                 std::span<const detail::Reservation> reservations = {}) const;
  tl::unexpected<Error> malformed(detail::WalkStatus why) const;
  SampleHandle lend(const Outlets& outlets, std::uint32_t body_bytes,
                    std::chrono::nanoseconds& timeout) noexcept;
  /// The memory of the last sample, if nobody has kept that and it is not too large.
  SampleHandle take_heap(std::size_t bytes) noexcept {
    if (bytes > recycled_bytes_max) return heap_->take(bytes);
    if (!recycled_ || !recycled_.is_only() || recycled_->capacity < bytes) recycled_ = heap_->take(bytes);
    return recycled_;
  }
  void fill_header(SampleBuffer& buffer, const FieldMask& mask, std::uint32_t body_bytes) const noexcept;
  PublishStatus move_together(SampleBuffer& sample);

  const Product product_;
  const TypeSupport& type_;
  const FieldMask full_;
  const detail::SampleLayout layout_;
  const std::shared_ptr<BufferPool> heap_;
  const detail::ProjectionPlan onto_itself_;  ///< closes the gaps of a loan that was shortened
  detail::Projection closing_;
  SampleHandle recycled_;              ///< from the heap; the next sample's, if nobody else has it by then
  detail::PostponedCopies postponed_;  ///< of the present sample
  std::uint32_t whole_bytes_ = 0;      ///< of the body of the present message with all its fields
  std::string why_invalid_;
  Time next_refusal_logged_{};  ///< not before; the log leaves out more of them
};

}  // namespace sft::core
