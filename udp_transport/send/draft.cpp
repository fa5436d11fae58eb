#include "udp_transport/send/draft.h"

#include <algorithm>

namespace sft::udp {

void Draft::keep_in_channels(const core::SampleHandle& sample,
                             const std::shared_ptr<core::BufferPool>& pool) {
  if (pool == nullptr || sample->owner == pool) return keep(sample);
  const std::size_t copy_bytes = std::max(handle_->projection.bytes(), sizeof(detail::SampleHeader));
  // If samples are borrowed, some reader may lag and need copies soon.
  if (jobs_->has_borrowed()) pool->expect(copy_bytes);
  if (jobs_->may_borrow(sample->capacity)) {
    keep(sample);
    return handle_->borrow();
  }
  core::SampleHandle copy = pool->take(copy_bytes, pool->limit_bytes() / 4);
  copy ? handle_->copy_body(std::move(copy)) : handle_->copy_body();
  is_kept_ = true;
}

}  // namespace sft::udp
