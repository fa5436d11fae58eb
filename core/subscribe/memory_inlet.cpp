#include "core/subscribe/memory_inlet.h"

#include <algorithm>
#include <utility>

namespace sft::core {

std::shared_ptr<BorrowingReader> MemoryInlet::replace(std::shared_ptr<BorrowingReader> port) {
  return std::exchange(port_, std::move(port));
}

MemoryInlet::Lost MemoryInlet::lose(std::size_t depth) {
  Lost lost{std::exchange(port_, nullptr), {}};
  if (lost.port == nullptr) return lost;
  while (SampleHandle sample = lost.port->take()) kept_.push_back(std::move(sample));
  for (; kept_.size() > depth; kept_.pop_front()) lost.dropped.push_back(std::move(kept_.front()));
  return lost;
}

SampleHandle MemoryInlet::take() {
  if (kept_.empty()) [[likely]]
    return port_ == nullptr ? SampleHandle() : port_->take();
  SampleHandle oldest = std::move(kept_.front());
  kept_.pop_front();
  return oldest;
}

SampleHandle MemoryInlet::take_of(EndpointId writer) {
  const auto is_it = [writer](const SampleHandle& sample) { return sample->writer == writer; };
  const auto kept = std::ranges::find_if(kept_, is_it);
  if (kept == kept_.end()) return port_ == nullptr ? SampleHandle() : port_->take_of(writer);
  SampleHandle oldest = std::move(*kept);
  kept_.erase(kept);
  return oldest;
}

}  // namespace sft::core
