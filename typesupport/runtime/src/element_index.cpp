#include "sft/detail/element_index.h"

#include <array>
#include <new>
#include <utility>
#include <vector>

namespace sft::detail {

namespace {

/// A position that is at most this number of elements ahead is found by walking, not by a table.
constexpr std::uint32_t near_elements = 8;

/// The minimum size of an element without a constant stride: the bytes of the length of a string or a
/// sequence.
constexpr std::uint32_t variable_bytes_min = 4;

constexpr std::uint64_t not_fixed = ~std::uint64_t{0};

std::uint64_t fixed_begin(const FieldMask& mask, const StructType& type, std::size_t leaf,
                          std::uint64_t first, std::uint32_t position) noexcept;

/// Returns the offset at which the selected members of a struct end. The struct begins at `offset`. Returns
/// not_fixed if strings or sequences are among the members.
std::uint64_t fixed_end(const FieldMask& mask, const StructType& type, std::size_t leaf,
                        std::uint64_t offset) noexcept {
  for (const Member& m : type.members) {
    const std::size_t leaves = leaf_count(m);
    if (mask.any_of(leaf, leaves)) {
      if (m.kind == Kind::string || m.shape == Shape::sequence) return not_fixed;
      offset = m.kind == Kind::structure
                   ? fixed_begin(mask, *m.type, leaf, offset, m.count)
                   : align_up(offset, size_of(m.kind)) + std::uint64_t{m.count} * size_of(m.kind);
      if (offset == not_fixed) return not_fixed;
    }
    leaf += leaves;
  }
  return offset;
}

/// Returns the offset of the element at `position`. All offsets that follow a member with the largest
/// alignment are relative to that member. So the end of an element modulo that alignment does not depend on
/// its beginning, and all elements from the second on have the same size.
std::uint64_t fixed_begin(const FieldMask& mask, const StructType& type, std::size_t leaf,
                          std::uint64_t first, std::uint32_t position) noexcept {
  if (position == 0) return first;
  const std::uint64_t second = fixed_end(mask, type, leaf, first);
  if (position == 1 || second == not_fixed) return second;
  const std::uint64_t stride = fixed_end(mask, type, leaf, second) - second;
  return second + std::uint64_t{position - 1} * stride;
}

std::uint32_t walk(const SampleState& s, const Elements& elements, std::uint32_t position,
                   KnownElement from) noexcept {
  if (position < from.position) from = {0, elements.first};
  std::uint32_t at = from.offset;
  for (std::uint32_t i = from.position; i < position && at != no_offset; ++i)
    at = next_element(s, elements, at);
  return at;
}

}  // namespace

std::uint32_t next_element(const SampleState& s, const Elements& elements, std::uint64_t offset) noexcept {
  return elements.type == nullptr ? skip_string(s, offset) : skip(s, *elements.type, elements.leaf, offset);
}

class ElementIndex::Table {
 public:
  const Elements& elements() const { return elements_; }
  const Table* next() const { return next_; }
  std::size_t memory() const { return sizeof(Table) + offsets_.capacity() * sizeof(std::uint32_t); }

  std::uint32_t offset(std::uint32_t position) const {
    return position < offsets_.size() ? offsets_[position] : no_offset;
  }

  /// Reserves the memory that fill() needs.
  void reset(const Elements& elements) {
    elements_ = elements;
    offsets_.clear();
    offsets_.reserve(elements.count);
  }

  void fill(const SampleState& s) noexcept {
    std::uint32_t at = elements_.first;
    while (at != no_offset) {
      offsets_.push_back(at);
      if (offsets_.size() == elements_.count) return;
      at = next_element(s, elements_, at);
    }
  }

 private:
  friend struct ElementIndex::Tables;
  Elements elements_;
  std::vector<std::uint32_t> offsets_;
  Table* next_ = nullptr;  ///< the next table, either of the chain or of the free tables
};

/// A hash table of chains. Readers take no mutex, since chains only grow while there are readers.
struct ElementIndex::Tables {
  std::array<std::atomic<Table*>, 64> chains{};
  Table* free = nullptr;
  std::size_t used = 0;
  std::uint64_t offsets = 0;  ///< the number of offsets in all used tables

  ~Tables() {
    for (std::atomic<Table*>& chain : chains) destroy(chain.load(std::memory_order_relaxed));
    destroy(free);
  }

  std::atomic<Table*>& chain_of(const Elements& elements) {
    const std::uint64_t key = elements.first + elements.leaf * 31;
    return chains[(key * 0x9E37'79B9'7F4A'7C15) >> 58];
  }

  const Table* find(const Elements& elements) {
    const Table* table = chain_of(elements).load(std::memory_order_acquire);
    while (table != nullptr && table->elements() != elements) table = table->next();
    return table;
  }

  void link(Table& table) {
    std::atomic<Table*>& chain = chain_of(table.elements());
    table.next_ = chain.load(std::memory_order_relaxed);
    chain.store(&table, std::memory_order_release);
  }

  void give_back(Table& table) {
    table.next_ = free;
    free = &table;
  }

  Table* take_free() {
    if (free == nullptr) return new Table;
    return std::exchange(free, free->next_);
  }

  void clear() noexcept {
    for (std::atomic<Table*>& chain : chains) {
      for (Table* table = chain.exchange(nullptr, std::memory_order_relaxed); table != nullptr;) {
        Table* const next = table->next_;
        give_back(*table);
        table = next;
      }
    }
    keep_some();
    used = 0;
    offsets = 0;
  }

 private:
  void keep_some() noexcept {
    std::size_t kept = 0;
    for (Table** at = &free; *at != nullptr; at = &(*at)->next_) {
      kept += (*at)->memory();
      if (kept <= kept_bytes_max) continue;
      destroy(std::exchange(*at, nullptr));
      return;
    }
  }

  static void destroy(Table* table) noexcept {
    while (table != nullptr) delete std::exchange(table, table->next_);
  }
};

ElementIndex::ElementIndex() = default;

ElementIndex::~ElementIndex() { delete tables_.load(std::memory_order_relaxed); }

const ElementIndex::Table* ElementIndex::table(const SampleState& s, const Elements& elements) noexcept {
  if (Tables* tables = tables_.load(std::memory_order_acquire)) {
    if (const Table* found = tables->find(elements)) return found;
  }
  Table* blank = nullptr;
  try {
    blank = blank_table(s, elements);
  } catch (const std::bad_alloc&) {
  }
  if (blank == nullptr) return nullptr;
  blank->fill(s);
  return publish(blank);
}

/// Returns an empty table; null if the sample has reached its limit of tables or of memory.
ElementIndex::Table* ElementIndex::blank_table(const SampleState& s, const Elements& elements) {
  Table* blank = nullptr;
  {
    const std::scoped_lock lock(mutex_);
    Tables* tables = tables_.load(std::memory_order_relaxed);
    if (tables == nullptr) tables_.store(tables = new Tables, std::memory_order_release);
    if (tables->used == tables_max || tables->offsets + elements.count > s.body_bytes / variable_bytes_min)
      return nullptr;
    blank = tables->take_free();
    ++tables->used;
    tables->offsets += elements.count;
  }
  try {
    blank->reset(elements);
  } catch (const std::bad_alloc&) {
    const std::scoped_lock lock(mutex_);
    tables_.load(std::memory_order_relaxed)->give_back(*blank);
    return nullptr;
  }
  return blank;
}

/// Publishes the table. If another thread has published an equal table first, returns the table of that
/// thread.
const ElementIndex::Table* ElementIndex::publish(Table* table) noexcept {
  const std::scoped_lock lock(mutex_);
  Tables* tables = tables_.load(std::memory_order_relaxed);
  if (const Table* found = tables->find(table->elements())) {
    --tables->used;
    tables->offsets -= table->elements().count;
    tables->give_back(*table);
    return found;
  }
  tables->link(*table);
  return table;
}

void ElementIndex::clear() noexcept {
  Tables* tables = tables_.load(std::memory_order_relaxed);
  if (tables != nullptr && tables->used != 0) tables->clear();
}

std::uint32_t element_begin(const SampleState& s, const Elements& elements, std::uint32_t position,
                            KnownElement known) noexcept {
  if (position == known.position) return known.offset;
  if (elements.type != nullptr) {
    const std::uint64_t begin = fixed_begin(*s.mask, *elements.type, elements.leaf, elements.first, position);
    if (begin != not_fixed) return begin <= s.body_bytes ? static_cast<std::uint32_t>(begin) : no_offset;
  }
  const bool is_near = position > known.position && position - known.position <= near_elements;
  if (s.elements != nullptr && !is_near && elements.count > near_elements) {
    if (const auto* table = s.elements->table(s, elements)) return table->offset(position);
  }
  return walk(s, elements, position, known);
}

}  // namespace sft::detail
