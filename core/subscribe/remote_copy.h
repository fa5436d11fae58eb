// Reduces a whole sample in shared memory to the sample that a reader on another host would get: the same
// projection is assembled and checked as if it had been received in datagrams. Parts of fields can remain in
// the whole sample.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/seam/buffer_pool.h"
#include "core/seam/sample_buffer.h"
#include "core/subscribe/asked.h"
#include "core/sync/lock_order.h"
#include "core/sync/mutex.h"
#include "sft/detail/parts_in_place.h"
#include "sft/detail/project.h"
#include "sft/type_support.h"

namespace sft::core {

class RemoteCopy;

/// Reads the parts of a sample in place, in the whole sample in shared memory, which the object holds. At
/// first only the small fields around the parts are copied. A part that is not contiguous is copied when its
/// bytes are requested, and the whole sample when its encoded form is requested.
class PartReader final : public detail::PartsInPlace {
 public:
  /// Begins to read the requested parts of `source`, whose positions are in `cuts`. `owner` provides memory
  /// and copies.
  void begin(std::shared_ptr<RemoteCopy> owner, SampleHandle source, std::shared_ptr<const Asked> asked,
             std::span<const detail::Cut> cuts);
  std::optional<detail::PartInPlace> find(std::size_t leaf) noexcept override;
  std::optional<std::span<const std::byte>> bytes_of(std::size_t leaf) noexcept override;
  const detail::SampleState& put_together() noexcept override;

  /// Returns the reader to its owner. Called when the sample is no longer read.
  static void end(PartReader* reader) noexcept;

 private:
  std::optional<std::size_t> number_of(std::size_t leaf) const;
  detail::PartInPlace place(std::size_t part) const;
  std::span<const std::byte> gathered(std::size_t part) noexcept SFT_EXCLUDES(mutex_);

  // The following members do not change while the reader is in use.
  std::shared_ptr<RemoteCopy> owner_;
  std::shared_ptr<const Asked> asked_;
  SampleHandle source_;
  detail::SampleState source_state_;
  std::vector<detail::Cut> cuts_;  ///< the positions of the parts

  /// Held while the bytes of a part are copied, since several threads may read the same sample.
  Mutex mutex_;
  std::vector<SampleHandle> copies_ SFT_GUARDED_BY(mutex_);  ///< the copied parts
  SampleHandle together_ SFT_GUARDED_BY(mutex_);
  /// The state of `together_`; written once, before was_put_together_ is set.
  detail::SampleState together_state_;
  bool was_put_together_ SFT_GUARDED_BY(mutex_) = false;
};

/// Any thread may call any function. Samples may outlive their subscriber, and keep this object alive.
class RemoteCopy final : public std::enable_shared_from_this<RemoteCopy> {
 public:
  /// `type` must outlive the object. Copies lie in memory of `pool`.
  static std::shared_ptr<RemoteCopy> make(const TypeSupport& type, std::shared_ptr<BufferPool> pool) {
    return std::shared_ptr<RemoteCopy>(new RemoteCopy(type, std::move(pool)));
  }

  /// Returns a copy that has only the requested fields and parts. Returns the sample itself if it has no more
  /// than that, or if it has parts of an earlier request. The handle is empty if there is no memory, or if
  /// the bytes are malformed. In these cases a reader on another host would miss the sample, too.
  SampleHandle of(SampleHandle sample, const detail::ProjectionPlan& asked) SFT_EXCLUDES(mutex_);

  struct InPlace {
    SampleHandle sample{};
    PartReader* parts = nullptr;  ///< reads the parts of fields in place; null: all fields are in `sample`
  };
  /// Does the same as of(), but leaves parts of fields in the whole sample if possible.
  InPlace in_place(SampleHandle sample, std::shared_ptr<const Asked> asked) SFT_EXCLUDES(mutex_);

  // The following functions are for PartReader.

  SampleHandle memory(std::size_t bytes) noexcept { return pool_->take(bytes); }
  detail::SampleState state(const SampleBuffer& sample) const {
    return state_of(sample, type_.index_slots());
  }
  void take_back(PartReader& reader) noexcept SFT_EXCLUDES(readers_mutex_);

 private:
  RemoteCopy(const TypeSupport& type, std::shared_ptr<BufferPool> pool)
      : type_(type), pool_(std::move(pool)) {}

  static bool is_as_asked(const SampleBuffer& sample, const detail::ProjectionPlan& asked);
  bool project(const SampleBuffer& sample, const detail::ProjectionPlan& asked, const FieldMask& present)
      SFT_REQUIRES(mutex_);
  /// Returns a copy. The handle is empty if there is no memory, or if the projected bytes are malformed.
  SampleHandle copy(const SampleBuffer& sample, const FieldMask& mask, std::uint64_t parts)
      SFT_REQUIRES(mutex_);
  bool fill(SampleBuffer& copy, const SampleBuffer& sample) const SFT_REQUIRES(mutex_);
  PartReader& take_reader() SFT_EXCLUDES(readers_mutex_);

  const TypeSupport& type_;
  const std::shared_ptr<BufferPool> pool_;
  /// Held while a thread copies a sample, so that one thread copies at a time.
  Mutex mutex_ SFT_ACQUIRED_AFTER(lock_order::endpoints) SFT_ACQUIRED_BEFORE(lock_order::endpoint);
  detail::Projection projection_ SFT_GUARDED_BY(mutex_);
  Mutex readers_mutex_;  ///< held for a few instructions, so that returning a reader never waits for a copy
  std::vector<std::unique_ptr<PartReader>> readers_ SFT_GUARDED_BY(readers_mutex_);
  std::vector<PartReader*> free_ SFT_GUARDED_BY(readers_mutex_);
};

}  // namespace sft::core
