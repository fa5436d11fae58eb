// Finds where the elements of collections begin, so that elements are accessed by position although CDR only
// lets one walk through them.
//
// Elements without strings and sequences among their selected leaves have a constant stride from the second
// one on, and nothing is stored. For others an ElementIndex remembers offsets, from the first jump on.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>

#include "sft/detail/type_table.h"
#include "sft/detail/walk.h"

namespace sft::detail {

/// Strings (`type` is null) or structs that lie behind one another in a body.
struct Elements {
  const StructType* type = nullptr;
  std::size_t leaf = 0;     ///< of structs: their first leaf in the root type
  std::uint32_t first = 0;  ///< offset at which the first one begins, before alignment
  std::uint32_t count = 0;

  friend bool operator==(const Elements&, const Elements&) = default;
};

/// Offset just behind one of the elements, that begins at `offset`; no_offset where the body ends before.
std::uint32_t next_element(const SampleState& s, const Elements& elements, std::uint64_t offset) noexcept;

/// An element that was reached before.
struct KnownElement {
  std::uint32_t position = 0;
  std::uint32_t offset = 0;
};

/// Returns where the element at `position` begins, or no_offset. Walks if the element is close behind `known`
/// or nothing can be remembered. Like every offset the result is a hint: whoever reads there checks.
std::uint32_t element_begin(const SampleState& s, const Elements& elements, std::uint32_t position,
                            KnownElement known) noexcept;

/// The offsets of one sample's elements, as far as somebody jumped to them. Any number of threads may use it
/// at once.
class ElementIndex {
 public:
  static constexpr std::size_t tables_max = 4096;  ///< collections of one sample; in others, jumps walk
  static constexpr std::size_t kept_bytes_max = 256 * 1024;  ///< from one sample to the next

  ElementIndex();
  ~ElementIndex();
  ElementIndex(const ElementIndex&) = delete;
  ElementIndex& operator=(const ElementIndex&) = delete;

  class Table;

  /// The offsets of `elements`, one each, fewer where the body ends before; found by walking once. Null where
  /// there is no memory for them, or the bytes of the body do not justify so many. Valid until clear().
  const Table* table(const SampleState& s, const Elements& elements) noexcept;

  /// Forgets the sample, but keeps memory for the next one. Not while anybody reads.
  void clear() noexcept;

 private:
  struct Tables;
  Table* blank_table(const SampleState& s, const Elements& elements);
  const Table* publish(Table* table) noexcept;

  std::atomic<Tables*> tables_{nullptr};  ///< made by the first jump of all
  std::mutex mutex_;                      ///< guards what changes them; never held over a walk
};

}  // namespace sft::detail
