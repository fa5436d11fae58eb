// Reads the parts of a sample in place, in the whole sample in shared memory, which the object holds. At
// first only the small fields around the parts are copied. A part that is not contiguous is copied when its
// bytes are requested, and the whole sample when its encoded form is requested.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/seam/sample_buffer.h"
#include "core/subscribe/asked.h"
#include "core/sync/mutex.h"
#include "sft/detail/parts_in_place.h"

namespace sft::core {

class PartReader final : public detail::PartsInPlace {
 public:
  /// Provides readers with memory and copies. It must live as long as any of its readers is in use. Any
  /// thread.
  class Owner {
   public:
    /// Returns memory, or an empty handle if there is none.
    virtual SampleHandle memory(std::size_t bytes) noexcept = 0;
    /// Returns a copy with the requested fields and parts. The handle is empty if there is no memory, or if
    /// the sample is malformed.
    virtual SampleHandle of(SampleHandle sample, const detail::ProjectionPlan& asked) = 0;
    virtual detail::SampleState state(const SampleBuffer& sample) const = 0;
    virtual void take_back(PartReader& reader) noexcept = 0;

   protected:
    ~Owner() = default;
  };

  /// Begins to read the requested parts of `source`, whose positions are in `cuts`.
  void begin(std::shared_ptr<Owner> owner, SampleHandle source, std::shared_ptr<const Asked> asked,
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
  std::shared_ptr<Owner> owner_;
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

}  // namespace sft::core
