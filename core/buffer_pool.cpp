#include "core/buffer_pool.h"

#include <algorithm>
#include <bit>
#include <new>

namespace sft::core {

namespace {

void destroy(SampleBuffer* buffer) noexcept {
  ::operator delete (buffer->data, std::align_val_t{64});
  delete buffer;
}

}  // namespace

std::shared_ptr<BufferPool> BufferPool::make(std::size_t limit_bytes) {
  return std::shared_ptr<BufferPool>(new BufferPool(limit_bytes));
}

BufferPool::~BufferPool() {
  for (auto& list : free_) std::for_each(list.begin(), list.end(), destroy);
}

SampleHandle BufferPool::take(std::size_t bytes) noexcept {
  const std::size_t shift =
      std::max<std::size_t>(std::bit_width(std::max<std::size_t>(bytes, 1) - 1), min_shift);
  if (shift >= min_shift + classes) return {};
  SampleBuffer* buffer = nullptr;
  {
    const std::scoped_lock lock(mutex_);
    auto& list = free_[shift - min_shift];
    if (!list.empty()) {
      buffer = list.back();
      list.pop_back();
    }
  }
  if (buffer == nullptr) buffer = make_buffer(std::size_t{1} << shift);
  if (buffer == nullptr) return {};
  new (buffer->data) SampleHeader{};
  buffer->receive_stamp_ns = 0;
  buffer->min_period_us = buffer->ordinal = 0;
  buffer->addressee = buffer->oldest_retained = 0;
  buffer->owner = shared_from_this();
  return SampleHandle(*buffer);
}

SampleBuffer* BufferPool::make_buffer(std::size_t capacity) noexcept {
  shrink(capacity);
  {
    const std::scoped_lock lock(mutex_);
    if (held_bytes_ + capacity > limit_bytes_) return nullptr;
    held_bytes_ += capacity;
  }
  auto* buffer = new (std::nothrow) SampleBuffer;
  auto* data = static_cast<std::byte*>(::operator new (capacity, std::align_val_t{64}, std::nothrow));
  if (buffer == nullptr || data == nullptr) {
    ::operator delete (data, std::align_val_t{64});
    delete buffer;
    const std::scoped_lock lock(mutex_);
    held_bytes_ -= capacity;
    return nullptr;
  }
  buffer->data = data;
  buffer->capacity = capacity;
  return buffer;
}

/// Frees kept buffers of other sizes until `needed` bytes fit within the limit.
void BufferPool::shrink(std::size_t needed) noexcept {
  for (;;) {
    SampleBuffer* victim = nullptr;
    {
      const std::scoped_lock lock(mutex_);
      if (held_bytes_ + needed <= limit_bytes_) return;
      for (auto list = free_.rbegin(); list != free_.rend() && victim == nullptr; ++list) {
        if (list->empty()) continue;
        victim = list->back();
        list->pop_back();
        held_bytes_ -= victim->capacity;
      }
    }
    if (victim == nullptr) return;
    destroy(victim);
  }
}

void BufferPool::recycle(SampleBuffer& buffer) noexcept {
  const auto list = static_cast<std::size_t>(std::countr_zero(buffer.capacity)) - min_shift;
  const std::scoped_lock lock(mutex_);
  try {
    free_[list].push_back(&buffer);
  } catch (const std::bad_alloc&) {
    held_bytes_ -= buffer.capacity;
    destroy(&buffer);
  }
}

}  // namespace sft::core
