// A reader on the publisher's host that requests a part of a message.
#pragma once

#include <memory>
#include <string_view>

#include "bench/typesupport/messages.h"
#include "core/seam/buffer_pool.h"
#include "core/subscribe/remote_copy.h"
#include "sft/type_support.h"

namespace sft::bench {

class LocalPart {
 public:
  /// Copies the message into memory like shared memory. The type must outlive this object.
  LocalPart(const TypeSupport& type, const Sample& whole, std::string_view selection);
  ~LocalPart();
  LocalPart(const LocalPart&) = delete;
  LocalPart& operator=(const LocalPart&) = delete;

  /// Does the work of take(), and the work when the sample is released.
  void take_and_release();
  /// Returns a copy of the part, as a reader on another host would receive it.
  core::SampleHandle copied() const { return copies_->of(sample_, *asked_->plan); }
  /// Returns the sample that is taken and kept.
  const detail::SampleState& state() const { return state_; }

 private:
  const std::shared_ptr<core::BufferPool> pool_ = core::BufferPool::make(std::size_t{64} << 20);
  const std::shared_ptr<core::RemoteCopy> copies_;
  const std::shared_ptr<const core::Asked> asked_;
  const core::SampleHandle sample_;
  core::RemoteCopy::InPlace part_;
  detail::SampleState state_;
};

}  // namespace sft::bench
