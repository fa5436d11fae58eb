// Copies a sample that lies whole in shared memory as a reader on another host would get it: the same
// projection, put together and checked as if its datagrams had come.
#pragma once

#include <memory>
#include <utility>

#include "core/seam/buffer_pool.h"
#include "core/seam/sample_buffer.h"
#include "sft/detail/project.h"
#include "sft/type_support.h"

namespace sft::core {

class RemoteCopy {
 public:
  /// `type` outlives it; copies lie in memory of `pool`.
  RemoteCopy(const TypeSupport& type, std::shared_ptr<BufferPool> pool)
      : type_(type), pool_(std::move(pool)) {}

  /// The sample itself if it has no more than is asked for, or parts of an earlier request. Empty if a reader
  /// on another host would miss the sample: if there is no memory, or if its bytes are not what they claim to
  /// be. One thread at a time.
  SampleHandle of(SampleHandle sample, const detail::ProjectionPlan& asked);

 private:
  bool project(const SampleBuffer& sample, const detail::ProjectionPlan& asked, const FieldMask& present);
  bool fill(SampleBuffer& copy, const SampleBuffer& sample) const;

  const TypeSupport& type_;
  const std::shared_ptr<BufferPool> pool_;
  detail::Projection projection_;
};

}  // namespace sft::core
