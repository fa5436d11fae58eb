// Makes the samples of one publisher: allocates memory for them, and writes header, index and body. The
// body is encoded from a message, converted from an encoded payload, or written by the program into a loan.
//
// The memory is taken from the port to shared memory if the port has readers, otherwise from the heap. A
// small sample reuses the memory of the previous sample, if no handle of that sample exists any more.
//
// The publisher's thread calls all functions. `timeout` is the time for which a function may wait for
// memory; the function subtracts from it the time that it has waited.
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
    const TypeSupport* type = nullptr;  ///< must outlive this object
    std::size_t max_sample_bytes = 0;
    std::function<void(const std::string& why)> refused;  ///< see PublisherCore::Spec
  };
  SampleMaker(Product product, std::shared_ptr<BufferPool> heap);

  /// Returns false if the message is invalid, that is, could not be sent to a reader of all fields;
  /// why_invalid() then returns the reason. If the outlets encode all fields anyway, the function returns
  /// true without a check, and encode() detects the fault.
  bool accepts(const Outlets& outlets, const detail::Message& message) {
    return outlets.whole || is_sendable(message);
  }
  /// A sample, or the status without one: `invalid`, which why_invalid() explains, or `no_memory`.
  struct Made {
    SampleHandle sample;
    PublishStatus why_not = PublishStatus::ok;
    std::uint32_t body_bytes = 0;
  };

  /// Encodes the fields of the message that the outlets need. If `may_postpone` is true, parts of the message
  /// may be copied later, when they are needed (SampleBuffer::postponed). In this case the message must live
  /// until sent() is called. REQUIRES: accepts().
  Made encode(const Outlets& outlets, const detail::Message& message, bool may_postpone,
              std::chrono::nanoseconds& timeout);
  /// Called when the message of the last encoded sample is not needed any more: all postponed copies were
  /// made, or will not be.
  void sent(SampleBuffer& sample) noexcept {
    if (postponed_.empty()) return;
    if (sample.postponed != nullptr)
      // If `postponed` is null, other threads may already read the sample, so it must not be written to.
      sample.postponed = nullptr;
    postponed_.clear();
  }
  /// Returns the reason why the last refused message could not be sent.
  const std::string& why_invalid() const { return why_invalid_; }

  /// Returns the size in bytes of the body that convert() makes from the payload.
  Result<std::uint32_t> converted_bytes(const detail::Payload& payload) const;
  Result<Made> convert(const Outlets& outlets, const detail::Payload& payload, std::uint32_t body_bytes,
                       std::chrono::nanoseconds& timeout);

  /// Lends memory for a message that the program writes itself: a sample with all fields, encoded from the
  /// prototype, with memory for the elements of the reserved sequences.
  Result<SampleHandle> loan(const Outlets& outlets, const void* prototype,
                            std::span<const detail::Reservation> reservations, detail::ReservedMemory memory,
                            std::chrono::nanoseconds& timeout);
  /// Lends memory for a body that the program encodes itself. The sample has no index before index() was
  /// called.
  Result<SampleHandle> loan_cdr(const Outlets& outlets, std::size_t body_bytes,
                                std::chrono::nanoseconds& timeout);
  /// Checks the body that the program has encoded, and makes its index.
  Result<void> index(SampleBuffer& sample) const;
  /// Moves the data of a loan whose sequences were shortened. The result is the same as if the shorter
  /// sequences had been encoded.
  PublishStatus close_gaps(SampleBuffer& sample) noexcept;

 private:
  /// The maximum size in bytes of the memory that is kept for the next sample.
  static constexpr std::size_t recycled_bytes_max = 4096;

  bool is_sendable(const detail::Message& message);
  [[gnu::cold, gnu::noinline]] PublishStatus refuse(const detail::Message& message, const FieldMask& mask);
  Error fault_of(const detail::Message& message, const FieldMask& mask,
                 std::span<const detail::Reservation> reservations = {}) const;
  tl::unexpected<Error> malformed(detail::WalkStatus why) const;
  Result<void> check_size(std::size_t body_bytes) const;
  SampleHandle lend(const Outlets& outlets, std::uint32_t body_bytes,
                    std::chrono::nanoseconds& timeout) noexcept;
  /// Returns heap memory. Reuses the memory of the last sample if no other handle of that sample exists,
  /// and if its size fits.
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
  const detail::ProjectionPlan onto_itself_;  ///< the plan by which a shortened loan is projected onto its
                                              ///< own type and memory, which removes the gaps after its
                                              ///< sequences
  detail::Projection closing_;
  /// Heap memory for the next sample; reused if the handle of the previous sample has been released.
  SampleHandle recycled_;
  detail::PostponedCopies postponed_;  ///< the postponed copies of the present sample
  std::uint32_t whole_bytes_ = 0;      ///< the size of the present message's body with all its fields
  std::string why_invalid_;
  Time next_refusal_logged_{};  ///< the earliest time at which a refusal is reported again
};

}  // namespace sft::core
