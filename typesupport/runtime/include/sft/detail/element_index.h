// Finds the beginnings of the elements of collections, so that elements are accessed by position. CDR
// itself has no such table and can only be walked through.
//
// Elements whose selected leaves contain no strings and sequences have a constant stride from the second
// element on. For them no offsets are stored. For other elements an ElementIndex stores offsets as soon as
// a program first jumps to an element without reading the elements before it.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>

#include "sft/detail/type_table.h"
#include "sft/detail/walk.h"

namespace sft::detail {

/// Strings (`type` is null) or structs in a body, one after the other.
struct Elements {
  const StructType* type = nullptr;
  std::size_t leaf = 0;     ///< the first leaf of the structs in the root type
  std::uint32_t first = 0;  ///< offset of the first element, before alignment
  std::uint32_t count = 0;

  friend bool operator==(const Elements&, const Elements&) = default;
};

/// Returns the offset at which the element that begins at `offset` ends; no_offset if the body ends before
/// that.
std::uint32_t next_element(const SampleState& s, const Elements& elements, std::uint64_t offset) noexcept;

/// An element whose offset is known from an earlier walk.
struct KnownElement {
  std::uint32_t position = 0;
  std::uint32_t offset = 0;
};

/// Returns the offset of the element at `position`, or no_offset. Walks if the element is only a few
/// positions after `known`, or if no offsets can be stored. Like every offset, the result is a hint, which
/// has to be checked before the read.
std::uint32_t element_begin(const SampleState& s, const Elements& elements, std::uint32_t position,
                            KnownElement known) noexcept;

/// The offsets of elements in one sample, for those collections in which a jump occurred. Any number of
/// threads may use an ElementIndex at once.
class ElementIndex {
 public:
  /// The maximum number of tables, one per collection. In further collections of a sample, an element
  /// is reached by a walk over those before it.
  static constexpr std::size_t tables_max = 4096;
  static constexpr std::size_t kept_bytes_max = 256 * 1024;  ///< limit of the memory that clear() keeps

  ElementIndex();
  ~ElementIndex();
  ElementIndex(const ElementIndex&) = delete;
  ElementIndex& operator=(const ElementIndex&) = delete;

  class Table;

  /// Returns the offset of each of `elements`, or of fewer if the body ends early. The first call walks
  /// once to find them. Returns null if there is no memory for the offsets, or if the body is too small for
  /// so many elements. Valid until clear().
  const Table* table(const SampleState& s, const Elements& elements) noexcept;

  /// Discards all offsets, but keeps memory for the next sample. Must not be called while a thread reads.
  void clear() noexcept;

 private:
  struct Tables;
  Table* blank_table(const SampleState& s, const Elements& elements);
  const Table* publish(Table* table) noexcept;

  std::atomic<Tables*> tables_{nullptr};  ///< made by the first jump in any sample
  std::mutex mutex_;                      ///< guards changes of the tables; never held over a walk
};

}  // namespace sft::detail
