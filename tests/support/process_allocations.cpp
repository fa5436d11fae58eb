#include "tests/support/process_allocations.h"

#include <execinfo.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdlib>
#include <new>

namespace {

std::atomic<std::uint64_t> allocations{0};

struct CallStack {
  std::array<void*, 24> frames{};
  int count = 0;
};
std::array<CallStack, 16> noted;
std::atomic<std::size_t> notes{noted.size()};

void note() noexcept {
  if (notes.load(std::memory_order_relaxed) >= noted.size()) return;
  const std::size_t place = notes.fetch_add(1, std::memory_order_relaxed);
  if (place >= noted.size()) return;
  CallStack& stack = noted[place];
  stack.count = ::backtrace(stack.frames.data(), static_cast<int>(stack.frames.size()));
}

void* allocate(std::size_t bytes, std::size_t alignment = alignof(std::max_align_t)) noexcept {
  allocations.fetch_add(1, std::memory_order_relaxed);
  note();
  return std::aligned_alloc(alignment, (bytes + alignment - 1) / alignment * alignment);
}

void* or_throw(void* memory) {
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}

}  // namespace

std::uint64_t sft::test::process_allocations() { return allocations.load(std::memory_order_relaxed); }

void sft::test::note_allocations() {
  CallStack first;  // the first call of backtrace() allocates memory itself, which is not recorded
  first.count = ::backtrace(first.frames.data(), static_cast<int>(first.frames.size()));
  noted.fill({});
  notes.store(0);
}

void sft::test::print_allocations() {
  const std::size_t count = std::min(notes.exchange(noted.size()), noted.size());
  for (std::size_t i = 0; i < count; ++i) {
    ::backtrace_symbols_fd(noted[i].frames.data(), noted[i].count, STDERR_FILENO);
    static_cast<void>(!::write(STDERR_FILENO, "\n", 1));
  }
}

void* operator new(std::size_t bytes) { return or_throw(allocate(bytes)); }
void* operator new(std::size_t bytes, const std::nothrow_t&) noexcept { return allocate(bytes); }
void* operator new(std::size_t bytes, std::align_val_t alignment) {
  return or_throw(allocate(bytes, static_cast<std::size_t>(alignment)));
}
void* operator new(std::size_t bytes, std::align_val_t alignment, const std::nothrow_t&) noexcept {
  return allocate(bytes, static_cast<std::size_t>(alignment));
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }
