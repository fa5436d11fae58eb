// Reads the parts of a sample where they lie: in the whole sample in shared memory, which it holds. Nothing
// is copied but the small fields around the parts; who asks for the bytes of a part that does not lie
// together, or for the encoded sample, gets a copy then.
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
  /// Gives readers what they need, and lives as long as one of them is out. Any thread.
  class Owner {
   public:
    /// Empty if there is none.
    virtual SampleHandle memory(std::size_t bytes) noexcept = 0;
    /// A copy with what is asked for; empty if there is no memory, or if the sample is malformed.
    virtual SampleHandle of(SampleHandle sample, const detail::ProjectionPlan& asked) = 0;
    virtual detail::SampleState state(const SampleBuffer& sample) const = 0;
    virtual void take_back(PartReader& reader) noexcept = 0;

   protected:
    ~Owner() = default;
  };

  /// Makes it read the parts of `source` that are asked for. They lie where `cuts` say.
  void begin(std::shared_ptr<Owner> owner, SampleHandle source, std::shared_ptr<const Asked> asked,
             std::span<const detail::Cut> cuts);
  std::optional<detail::PartInPlace> find(std::size_t leaf) noexcept override;
  std::optional<std::span<const std::byte>> bytes_of(std::size_t leaf) noexcept override;
  const detail::SampleState& put_together() noexcept override;

  /// Gives it back to its owner: nobody reads the sample any more.
  static void end(PartReader* reader) noexcept;

 private:
  std::optional<std::size_t> number_of(std::size_t leaf) const;
  detail::PartInPlace place(std::size_t part) const;
  std::span<const std::byte> gathered(std::size_t part) noexcept SFT_EXCLUDES(mutex_);

  // While it is out these do not change.
  std::shared_ptr<Owner> owner_;
  std::shared_ptr<const Asked> asked_;
  SampleHandle source_;
  detail::SampleState source_state_;
  std::vector<detail::Cut> cuts_;  ///< of the parts

  Mutex mutex_;  ///< held while the bytes of a part are copied, by one of those who read the same sample
  std::vector<SampleHandle> copies_ SFT_GUARDED_BY(mutex_);  ///< of the parts
  SampleHandle together_ SFT_GUARDED_BY(mutex_);
  detail::SampleState together_state_;  ///< of `together_`: written once, before was_put_together_ is true
  bool was_put_together_ SFT_GUARDED_BY(mutex_) = false;
};

}  // namespace sft::core
