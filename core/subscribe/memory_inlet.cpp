#include "core/subscribe/memory_inlet.h"

#include <utility>

namespace sft::core {

MemoryInlet::Port MemoryInlet::replace(Port port) { return std::exchange(port_, std::move(port)); }

MemoryInlet::Port MemoryInlet::lose() {
  if (port_ == nullptr) return nullptr;
  return std::exchange(lost_, std::exchange(port_, nullptr));
}

MemoryInlet::Port MemoryInlet::release(bool also_if_some_wait) {
  if (lost_ == nullptr || (lost_->some_wait() && !also_if_some_wait)) return nullptr;
  return std::exchange(lost_, nullptr);
}

SampleHandle MemoryInlet::take() {
  SampleHandle sample;
  if (lost_ != nullptr) [[unlikely]]
    sample = lost_->take();
  if (!sample && port_ != nullptr) sample = port_->take();
  return sample;
}

SampleHandle MemoryInlet::take_of(EndpointId writer) {
  SampleHandle sample;
  if (lost_ != nullptr) sample = lost_->take_of(writer);
  if (!sample && port_ != nullptr) sample = port_->take_of(writer);
  return sample;
}

bool MemoryInlet::some_wait() const {
  return (lost_ != nullptr && lost_->some_wait()) || (port_ != nullptr && port_->some_wait());
}

std::uint64_t MemoryInlet::held_too_many() const {
  return (lost_ == nullptr ? 0 : lost_->held_too_many()) + (port_ == nullptr ? 0 : port_->held_too_many());
}

}  // namespace sft::core
