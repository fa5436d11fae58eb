#include "core/seam/buffer_pool.h"

#include <sys/mman.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <new>
#include <utility>

#include "core/platform/huge_pages.h"

namespace sft::core {

namespace {

constexpr std::size_t min_shift = 9;  // 512 bytes; 19 classes go up to 128 MiB
constexpr std::size_t extra_bytes_max = 8 * 1024;

constexpr std::size_t capacity_of(std::size_t size_class) {
  const std::size_t round = std::size_t{1} << (min_shift + size_class);
  return round + std::min(round / 8, extra_bytes_max);
}

/// Returns the number of the smallest class whose buffers hold `bytes` bytes.
constexpr std::size_t class_for(std::size_t bytes) {
  const auto shift = static_cast<std::size_t>(std::bit_width(bytes));  // 2^shift is more than `bytes`
  if (shift <= min_shift) return 0;
  const std::size_t below = shift - 1 - min_shift;
  return bytes <= capacity_of(below) ? below : below + 1;
}

/// The limits of stock(): the minimum size of the buffers that it prepares, the maximum size of such a
/// buffer as a fraction of the pool's limit (1/8), and the number of buffers of each size. Two buffers are
/// prepared, so that one of them may be taken while another one is being prepared.
constexpr std::size_t stocked_bytes_min = 256 * 1024, stocked_part_max = 8, stocked = 2;
constexpr std::size_t page_bytes = 4096;  // pages of the system have at least this size

/// Buffers of these classes share mapped blocks. All others are mapped one by one. So all of their memory
/// returns to the system. An allocator keeps freed blocks: that of glibc keeps blocks of up to 32 MiB once
/// the program has freed a block of such a size.
constexpr std::size_t small_classes = SmallBuffers::kinds;
static_assert(capacity_of(0) % SmallBuffers::alignment == 0 &&
              capacity_of(small_classes - 1) < SmallBuffers::block_bytes / 6);

/// Returns the size in bytes of the mapping for a buffer. A mapping whose end is cut off ends at a multiple
/// of the largest page size of Linux.
constexpr std::size_t mapped_bytes(std::size_t capacity) {
  constexpr std::size_t largest_page_bytes = 64 * 1024;
  if (capacity < huge_page_bytes) return capacity;
  return (capacity + largest_page_bytes - 1) / largest_page_bytes * largest_page_bytes;
}

/// Maps a buffer; returns null if there is no memory. Large buffers lie in huge pages, if the system has
/// them, because copying from and to cold memory is faster there.
std::byte* map(std::size_t capacity) noexcept {
  const std::size_t bytes = mapped_bytes(capacity);
  const std::size_t alignment = capacity < huge_page_bytes ? 0 : huge_page_bytes;
  void* const mapped =
      ::mmap(nullptr, bytes + alignment, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (mapped == MAP_FAILED) return nullptr;
  auto* const begin = static_cast<std::byte*>(mapped);
  if (alignment == 0) return begin;
  const std::size_t before = alignment - reinterpret_cast<std::uintptr_t>(begin) % alignment;
  ::munmap(begin, before);
  if (before != alignment) ::munmap(begin + before + bytes, alignment - before);
  ::madvise(begin + before, capacity / huge_page_bytes * huge_page_bytes, MADV_HUGEPAGE);
  return begin + before;
}

}  // namespace

std::shared_ptr<BufferPool> BufferPool::make(std::size_t limit_bytes) {
  return std::shared_ptr<BufferPool>(new BufferPool(limit_bytes));
}

BufferPool::~BufferPool() {
  for (auto& list : free_) destroy(list);
}

std::byte* BufferPool::allocate(std::size_t capacity) noexcept {
  const std::size_t size_class = class_for(capacity);
  return size_class < small_classes ? small_.take(size_class, capacity) : map(capacity);
}

void BufferPool::release(std::byte* data, std::size_t capacity) noexcept {
  if (data == nullptr) return;
  if (class_for(capacity) < small_classes) return small_.give_back(data);
  ::munmap(data, mapped_bytes(capacity));
}

void BufferPool::destroy(std::span<SampleBuffer* const> buffers) noexcept {
  for (SampleBuffer* const buffer : buffers) {
    release(buffer->data, buffer->capacity);
    delete buffer;
  }
}

SampleHandle BufferPool::take(std::size_t bytes, std::size_t leave_bytes) noexcept {
  const std::size_t size_class = class_for(bytes);
  if (size_class >= classes) return {};
  const std::size_t capacity = capacity_of(size_class);
  SampleBuffer* buffer = nullptr;
  {
    const Lock lock(mutex_);
    if (lent_bytes_ + capacity + leave_bytes > limit_bytes_) return {};
    lent_bytes_ += capacity;
    buffer = pick(size_class);
  }
  if (buffer == nullptr) buffer = make_buffer(capacity);
  if (buffer == nullptr) {
    const Lock lock(mutex_);
    lent_bytes_ -= capacity;
    return {};
  }
  return hand_out(*buffer, shared_from_this());
}

SampleHandle BufferPool::hand_out(SampleBuffer& buffer, std::shared_ptr<BufferOwner> self) noexcept {
  new (buffer.data) detail::SampleHeader{};
  buffer.receive_stamp_ns = 0;
  buffer.origin() = {};
  buffer.owner = std::move(self);
  return SampleHandle(buffer);
}

void BufferPool::take_kept(std::size_t bytes, std::size_t leave_bytes, std::size_t count,
                           std::vector<SampleHandle>& buffers) {
  const std::size_t size_class = class_for(bytes);
  if (size_class >= classes) return;
  const std::size_t capacity = capacity_of(size_class);
  const std::shared_ptr<BufferOwner> self = shared_from_this();
  buffers.reserve(buffers.size() + count);
  const Lock lock(mutex_);
  for (; count > 0 && !free_[size_class].empty(); --count) {
    if (lent_bytes_ + capacity + leave_bytes > limit_bytes_) return;
    lent_bytes_ += capacity;
    buffers.push_back(hand_out(*pick(size_class), self));
  }
}

/// Returns the kept buffer that was used last, because this buffer is the most likely to be in a cache.
/// Returns null if no buffer of the class is kept.
SampleBuffer* BufferPool::pick(std::size_t size_class) noexcept {
  auto& list = free_[size_class];
  if (list.empty()) return nullptr;
  SampleBuffer* const buffer = list.back();
  list.pop_back();
  unneeded_[size_class] = std::min(unneeded_[size_class], list.size());
  return buffer;
}

SampleBuffer* BufferPool::make_buffer(std::size_t capacity) noexcept {
  shrink(capacity);
  return reserve(capacity) ? make_reserved(capacity) : nullptr;
}

bool BufferPool::reserve(std::size_t capacity) noexcept {
  const Lock lock(mutex_);
  if (held_bytes_ + capacity > limit_bytes_) return false;
  held_bytes_ += capacity;
  return true;
}

SampleBuffer* BufferPool::make_reserved(std::size_t capacity) noexcept {
  auto* buffer = new (std::nothrow) SampleBuffer;
  std::byte* const data = allocate(capacity);
  if (buffer == nullptr || data == nullptr) {
    release(data, capacity);
    delete buffer;
    const Lock lock(mutex_);
    held_bytes_ -= capacity;
    return nullptr;
  }
  buffer->data = data;
  buffer->capacity = capacity;
  return buffer;
}

void BufferPool::expect(std::size_t bytes) noexcept {
  const std::size_t size_class = class_for(bytes);
  if (size_class >= classes) return;
  const Lock lock(mutex_);
  expected_.set(size_class);
}

void BufferPool::stock() noexcept {
  std::bitset<classes> expected;
  {
    const Lock lock(mutex_);
    expected = std::exchange(expected_, {});
  }
  for (std::size_t size_class = class_for(stocked_bytes_min); size_class < classes; ++size_class) {
    if (expected.test(size_class) && capacity_of(size_class) <= limit_bytes_ / stocked_part_max)
      while (stock_one(size_class)) {
      }
  }
}

/// Prepares one buffer. Returns false if enough buffers of this class are kept, or if there is no memory for
/// another one.
bool BufferPool::stock_one(std::size_t size_class) noexcept {
  const std::size_t capacity = capacity_of(size_class);
  {
    const Lock lock(mutex_);
    if (free_[size_class].size() >= stocked) return false;
  }
  SampleBuffer* const buffer = reserve(capacity) ? make_reserved(capacity) : nullptr;
  if (buffer == nullptr) return false;
  for (std::size_t at = 0; at < capacity; at += page_bytes) buffer->data[at] = std::byte{};
  const Lock lock(mutex_);
  keep(*buffer);
  return true;
}

/// At the end of each period, returns the buffers that were not needed during the period to the system. The
/// buffers that have been unused for the longest time are at the front of their list. There may be very
/// many small buffers: one call frees only some of them, and later calls free the rest.
void BufferPool::give_back(Time now) noexcept {
  if (now < period_ends_) return;
  std::array<SampleBuffer*, 1024> unneeded{};
  std::size_t found = 0;
  {
    const Lock lock(mutex_);
    for (std::size_t size_class = 0; size_class < classes; ++size_class) {
      auto& list = free_[size_class];
      const std::size_t count = std::min({unneeded_[size_class], list.size(), unneeded.size() - found});
      const auto end = list.begin() + static_cast<std::ptrdiff_t>(count);
      std::copy(list.begin(), end, unneeded.begin() + static_cast<std::ptrdiff_t>(found));
      list.erase(list.begin(), end);
      unneeded_[size_class] -= count;
      held_bytes_ -= count * capacity_of(size_class);
      found += count;
    }
    if (found < unneeded.size()) {
      period_ends_ = now + period;
      for (std::size_t size_class = 0; size_class < classes; ++size_class)
        unneeded_[size_class] = free_[size_class].size();
    }
  }
  destroy(std::span(unneeded).first(found));
}

/// Frees kept buffers of other sizes until `needed` bytes fit within the limit.
void BufferPool::shrink(std::size_t needed) noexcept {
  for (;;) {
    SampleBuffer* victim = nullptr;
    {
      const Lock lock(mutex_);
      if (held_bytes_ + needed <= limit_bytes_) return;
      for (auto list = free_.rbegin(); list != free_.rend() && victim == nullptr; ++list) {
        if (list->empty()) continue;
        victim = list->back();
        list->pop_back();
        held_bytes_ -= victim->capacity;
      }
    }
    if (victim == nullptr) return;
    destroy({&victim, 1});
  }
}

void BufferPool::recycle(SampleBuffer& buffer) noexcept {
  const Lock lock(mutex_);
  lent_bytes_ -= buffer.capacity;
  keep(buffer);
}

void BufferPool::keep(SampleBuffer& buffer) noexcept {
  try {
    free_[class_for(buffer.capacity)].push_back(&buffer);
  } catch (const std::bad_alloc&) {
    held_bytes_ -= buffer.capacity;
    SampleBuffer* const dropped = &buffer;
    destroy({&dropped, 1});
  }
}

}  // namespace sft::core
