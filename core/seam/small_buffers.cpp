#include "core/seam/small_buffers.h"

#include <sys/mman.h>

#include <cstdint>
#include <cstring>
#include <new>
#include <utility>

namespace sft::core {

/// The head of a block, whose buffers lie behind it. The block is aligned to its size, so that the address of
/// a buffer leads to its block.
struct alignas(SmallBuffers::alignment) SmallBuffers::Block {
  std::size_t kind = 0;
  std::size_t buffer_bytes = 0;
  Block* previous = nullptr;  ///< in the list of the blocks with room
  Block* next = nullptr;
  std::size_t in_use = 0;     ///< number of buffers that are in use
  std::size_t ever_used = 0;  ///< number of buffers that were ever in use; the others' memory is untouched
  std::byte* free = nullptr;  ///< the buffer that was given back last; it begins with the address of the next

  static Block& of(std::byte* buffer) {
    return *reinterpret_cast<Block*>(reinterpret_cast<std::uintptr_t>(buffer) / block_bytes * block_bytes);
  }
  std::size_t most() const { return (block_bytes - sizeof(Block)) / buffer_bytes; }
  std::byte* buffer(std::size_t i) { return reinterpret_cast<std::byte*>(this + 1) + i * buffer_bytes; }
};

namespace {

constexpr std::size_t block_bytes = SmallBuffers::block_bytes;

void* map_bytes(std::size_t bytes) noexcept {
  void* const mapped = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  return mapped == MAP_FAILED ? nullptr : mapped;
}

/// Returns a new block; null if there is no memory. The system usually maps it beside the last one, and thus
/// aligned.
void* map_block() noexcept {
  void* const block = map_bytes(block_bytes);
  if (block == nullptr || reinterpret_cast<std::uintptr_t>(block) % block_bytes == 0) return block;
  ::munmap(block, block_bytes);
  auto* const begin = static_cast<std::byte*>(map_bytes(2 * block_bytes));
  if (begin == nullptr) return nullptr;
  const std::size_t before = block_bytes - reinterpret_cast<std::uintptr_t>(begin) % block_bytes;
  ::munmap(begin, before);
  if (before != block_bytes) ::munmap(begin + before + block_bytes, block_bytes - before);
  return begin + before;
}

}  // namespace

std::byte* SmallBuffers::take(std::size_t kind, std::size_t bytes) noexcept {
  {
    const Lock lock(mutex_);
    if (Block* const block = with_room_[kind]) return take_from(*block);
  }
  void* const mapped = map_block();
  if (mapped == nullptr) return nullptr;
  Block& block = *new (mapped) Block{.kind = kind, .buffer_bytes = bytes};
  const Lock lock(mutex_);
  link(block);
  return take_from(block);
}

std::byte* SmallBuffers::take_from(Block& block) noexcept {
  std::byte* buffer = block.free;
  if (buffer == nullptr) {
    buffer = block.buffer(block.ever_used++);
  } else {
    std::memcpy(&block.free, buffer, sizeof block.free);
  }
  if (++block.in_use == block.most()) unlink(block);
  return buffer;
}

void SmallBuffers::give_back(std::byte* buffer) noexcept {
  Block& block = Block::of(buffer);
  {
    const Lock lock(mutex_);
    std::memcpy(buffer, &block.free, sizeof block.free);
    block.free = buffer;
    if (block.in_use-- == block.most()) link(block);
    if (block.in_use != 0) return;
    unlink(block);
  }
  ::munmap(&block, block_bytes);
}

void SmallBuffers::link(Block& block) noexcept {
  block.previous = nullptr;
  block.next = std::exchange(with_room_[block.kind], &block);
  if (block.next != nullptr) block.next->previous = &block;
}

void SmallBuffers::unlink(Block& block) noexcept {
  (block.previous == nullptr ? with_room_[block.kind] : block.previous->next) = block.next;
  if (block.next != nullptr) block.next->previous = block.previous;
}

}  // namespace sft::core
