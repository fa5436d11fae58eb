// Reads the parts of a sample in place: in the whole sample in shared memory, which it holds. At first only
// the small fields around the parts are copied. A part that is not contiguous is copied when its bytes are
// asked for, and the sample is copied when its encoded form is asked for.
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
  /// Provides readers with memory and copies. It lives as long as any of its readers is in use. Any thread.
  class Owner {
   public:
    /// Returns memory; empty if there is none.
    virtual SampleHandle memory(std::size_t bytes) noexcept = 0;
    /// Returns a copy with what is asked for; empty if there is no memory, or if the sample is malformed.
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

  /// Returns the reader to its owner when the sample is no longer read.
  static void end(PartReader* reader) noexcept;

 private:
  std::optional<std::size_t> number_of(std::size_t leaf) const;
  detail::PartInPlace place(std::size_t part) const;
  std::span<const std::byte> gathered(std::size_t part) noexcept SFT_EXCLUDES(mutex_);

  // These do not change while the reader is in use.
  std::shared_ptr<Owner> owner_;
  std::shared_ptr<const Asked> asked_;
  SampleHandle source_;
  detail::SampleState source_state_;
  std::vector<detail::Cut> cuts_;  ///< the positions of the parts

  Mutex
      mutex_;  ///< held while the bytes of a part are copied, since several threads may read the same sample
  std::vector<SampleHandle> copies_ SFT_GUARDED_BY(mutex_);  ///< the copied parts
  SampleHandle together_ SFT_GUARDED_BY(mutex_);
  detail::SampleState
      together_state_;  ///< the state of `together_`; written once, before was_put_together_ is set
  bool was_put_together_ SFT_GUARDED_BY(mutex_) = false;
};

}  // namespace sft::core
