#include "shm_transport/host/replaced_functions.h"

#include <dlfcn.h>
#include <link.h>

#include <array>
#include <cstdint>
#include <string_view>

#include "shm_transport/host/iceoryx.h"

// The list of free chunks: each exchange of the head increments the count (abaCounter) of the head that it
// replaces, and not the count of an attempt that has failed. A thread that takes a chunk sees all writes to
// the list that were made before the chunk was given back.
namespace iox::concurrent {

bool LoFFLi::pop(Index_t& index) noexcept {
  Index_t* const next_free = m_nextFreeIndex.get();
  Node head = m_head.load(std::memory_order_acquire);
  Node next{};
  do {
    if (head.indexToNextFreeIndex >= m_size) return false;
    // Other threads may meanwhile take this chunk and give it back. Then the count has changed, and the
    // exchange fails.
    next.indexToNextFreeIndex = __atomic_load_n(&next_free[head.indexToNextFreeIndex], __ATOMIC_RELAXED);
    next.abaCounter = head.abaCounter + 1;
  } while (!m_head.compare_exchange_weak(head, next, std::memory_order_acq_rel, std::memory_order_acquire));
  index = head.indexToNextFreeIndex;
  __atomic_store_n(&next_free[index], m_invalidIndex, __ATOMIC_RELAXED);
  return true;
}

bool LoFFLi::push(const Index_t index) noexcept {
  Index_t* const next_free = m_nextFreeIndex.get();
  const bool is_taken =
      index < m_size && __atomic_load_n(&next_free[index], __ATOMIC_RELAXED) == m_invalidIndex;
  if (!is_taken) return false;
  Node head = m_head.load(std::memory_order_acquire);
  Node next{};
  do {
    __atomic_store_n(&next_free[index], head.indexToNextFreeIndex, __ATOMIC_RELAXED);
    next = {index, head.abaCounter + 1};
  } while (!m_head.compare_exchange_weak(head, next, std::memory_order_acq_rel, std::memory_order_acquire));
  return true;
}

using Places = IndexQueue<sft::shm::queue_places_max, std::uint64_t>;

/// A thread that pops this place sees all earlier writes, such as the element in the place.
template <>
void Places::push(const std::uint64_t place) noexcept {
  Index at = m_writePosition.load(std::memory_order_relaxed);
  for (;;) {
    Cell& cell = m_cells[at.getIndex()];
    Index former = cell.load(std::memory_order_relaxed);
    if (former.isOneCycleBehind(at) &&
        cell.compare_exchange_weak(former, Index(place, at.getCycle()), std::memory_order_release,
                                   std::memory_order_relaxed))
      break;
    if (former.getCycle() != at.getCycle()) {
      at = m_writePosition.load(std::memory_order_relaxed);
    } else if (const Index next = at + 1;  // the cell is filled, but the position not moved yet
               m_writePosition.compare_exchange_strong(at, next, std::memory_order_release,
                                                       std::memory_order_relaxed)) {
      at = next;
    }
  }
  // If this fails, another thread has moved the position.
  m_writePosition.compare_exchange_strong(at, at + 1, std::memory_order_release, std::memory_order_relaxed);
}

template <>
bool Places::pop(std::uint64_t& place) noexcept {
  Index at = m_readPosition.load(std::memory_order_relaxed);
  for (;;) {
    const Index value = m_cells[at.getIndex()].load(std::memory_order_acquire);
    if (value.getCycle() == at.getCycle()) {
      if (m_readPosition.compare_exchange_weak(at, at + 1, std::memory_order_relaxed,
                                               std::memory_order_relaxed)) {
        place = value.getIndex();
        return true;
      }
    } else if (value.isOneCycleBehind(at)) {
      return false;
    } else {
      at = m_readPosition.load(std::memory_order_relaxed);
    }
  }
}

template <>
bool Places::popIfSizeIsAtLeast(const std::uint64_t size, std::uint64_t& place) noexcept {
  if (size == 0) return pop(place);
  // Loaded with acquire, because this function does not check in the cell whether the cell was filled.
  const Index end = m_writePosition.load(std::memory_order_acquire);
  Index at = m_readPosition.load(std::memory_order_relaxed);
  const std::int64_t waiting = end - at;  // negative if other threads have moved on meanwhile
  if (waiting < 0 || static_cast<std::uint64_t>(waiting) < size) return false;
  const Index value = m_cells[at.getIndex()].load(std::memory_order_acquire);
  if (!m_readPosition.compare_exchange_strong(at, at + 1, std::memory_order_relaxed,
                                              std::memory_order_relaxed))
    return false;
  place = value.getIndex();
  return true;
}

}  // namespace iox::concurrent

namespace sft::shm {

namespace {

constexpr std::array<std::string_view, 5> replaced{
    "_ZN3iox10concurrent6LoFFLi3popERj",
    "_ZN3iox10concurrent6LoFFLi4pushEj",
    "_ZN3iox10concurrent10IndexQueueILm256EmE3popERm",
    "_ZN3iox10concurrent10IndexQueueILm256EmE4pushEm",
    "_ZN3iox10concurrent10IndexQueueILm256EmE18popIfSizeIsAtLeastEmRm",
};

/// Returns the loaded file whose code has this address; null if there is no such file.
const void* file_of(const void* code) {
  Dl_info info{};
  return dladdr(code, &info) != 0 ? info.dli_fbase : nullptr;
}

/// The calls that a loaded file makes through its table.
class CallTable {
 public:
  explicit CallTable(const dl_phdr_info& file) : base_(file.dlpi_addr) {
    for (const auto* header = file.dlpi_phdr; header != file.dlpi_phdr + file.dlpi_phnum; ++header) {
      if (header->p_type == PT_DYNAMIC) read(at<const ElfW(Dyn)>(header->p_vaddr));
    }
  }
  /// Returns the number of replaced functions in the table whose code is in the same file as `code`.
  std::size_t count_replaced(const void* code) const {
    std::size_t count = 0;
    for (std::size_t i = 0; i < calls_; ++i) {
      const auto& symbol = symbols_[ELF64_R_SYM(call_[i].r_info)];
      for (const std::string_view name : replaced) {
        if (name == names_ + symbol.st_name && file_of(*at<const void* const>(call_[i].r_offset)) == code)
          ++count;
      }
    }
    return count;
  }

 private:
  template <class T>
  T* at(ElfW(Addr) offset) const {
    return reinterpret_cast<T*>(base_ + offset);
  }
  /// The addresses in this list are absolute: the dynamic linker has added the base.
  void read(const ElfW(Dyn) * entry) {
    for (; entry->d_tag != DT_NULL; ++entry) {
      if (entry->d_tag == DT_SYMTAB) symbols_ = reinterpret_cast<const ElfW(Sym)*>(entry->d_un.d_ptr);
      if (entry->d_tag == DT_STRTAB) names_ = reinterpret_cast<const char*>(entry->d_un.d_ptr);
      if (entry->d_tag == DT_JMPREL) call_ = reinterpret_cast<const ElfW(Rela)*>(entry->d_un.d_ptr);
      if (entry->d_tag == DT_PLTRELSZ) calls_ = entry->d_un.d_val / sizeof *call_;
    }
  }

  ElfW(Addr) base_;
  const ElfW(Sym) * symbols_ = nullptr;
  const char* names_ = nullptr;
  const ElfW(Rela) * call_ = nullptr;
  std::size_t calls_ = 0;
};

int count_if_of_iceoryx(dl_phdr_info* file, std::size_t, void* count) {
  if (std::string_view(file->dlpi_name).find("/libiceoryx_posh.so") == std::string_view::npos) return 0;
  *static_cast<std::size_t*>(count) =
      CallTable(*file).count_replaced(file_of(reinterpret_cast<const void*>(&functions_are_replaced)));
  return 1;
}

}  // namespace

bool functions_are_replaced() {
  std::size_t count = 0;
  dl_iterate_phdr(&count_if_of_iceoryx, &count);
  return count == replaced.size();
}

}  // namespace sft::shm
