#include "selection_bytes.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <string>
#include <utility>

namespace sft {

namespace {

using Bytes = std::vector<std::byte>;
using Condition = Selection::Condition;
using Part = Selection::Part;
using Range = Selection::Range;

// The flags in the first byte of a selection. They say what follows the mask.
constexpr std::uint8_t has_parts = 1, has_conditions = 2, has_period = 4;
// The flags in the first byte of a part.
constexpr std::uint8_t has_rows = 1, has_columns = 2, has_channels = 4, has_rule = 8;
// The flag in the first byte of a condition. That byte also has the kind, and the comparison from bit 3 on.
constexpr std::uint8_t is_percent = 0x40;
constexpr unsigned comparison_shift = 3;
// The form of a number, in its first byte.
enum class NumberForm : std::uint8_t { none, natural, negative, real };

void put(Bytes& out, std::uint64_t number) {
  for (; number >= 0x80; number >>= 7) out.push_back(static_cast<std::byte>(number | 0x80));
  out.push_back(static_cast<std::byte>(number));
}

void put_byte(Bytes& out, std::uint8_t byte) { out.push_back(static_cast<std::byte>(byte)); }

void put(Bytes& out, std::string_view text) {
  put(out, text.size());
  for (const char c : text) out.push_back(static_cast<std::byte>(c));
}

/// Writes a range. An open end is written as 0. An empty range, whose end is 0, too, is written with a step
/// of 0.
void put(Bytes& out, const Range& range) {
  put(out, range.begin);
  put(out, range.end == Range::no_end ? 0 : range.end);
  put(out, range.is_empty() ? 0 : range.step);
}

void put(Bytes& out, const Selection::Number& number) {
  if (const auto* real = std::get_if<double>(&number)) {
    put_byte(out, static_cast<std::uint8_t>(NumberForm::real));
    const auto bits = std::bit_cast<std::uint64_t>(*real);
    for (int byte = 0; byte < 8; ++byte) put_byte(out, static_cast<std::uint8_t>(bits >> (8 * byte)));
  } else if (const auto* whole = std::get_if<std::int64_t>(&number); whole != nullptr && *whole < 0) {
    put_byte(out, static_cast<std::uint8_t>(NumberForm::negative));
    put(out, ~static_cast<std::uint64_t>(*whole));
  } else {
    put_byte(out, static_cast<std::uint8_t>(NumberForm::natural));
    put(out, whole != nullptr ? static_cast<std::uint64_t>(*whole) : std::get<std::uint64_t>(number));
  }
}

/// Takes values from the front of the bytes. After the first error all numbers are 0.
class Reader {
 public:
  explicit Reader(std::span<const std::byte> bytes) : rest_(bytes) {}

  bool is_well() const { return is_well_; }
  bool is_done() const { return is_well_ && rest_.empty(); }

  std::uint8_t byte() {
    const auto taken = take(1);
    return taken.empty() ? 0 : std::to_integer<std::uint8_t>(taken.front());
  }
  std::uint64_t number() {
    std::uint64_t value = 0;
    for (unsigned shift = 0; shift < 64 && is_well_; shift += 7) {
      const std::uint8_t next = byte();
      value |= static_cast<std::uint64_t>(next & 0x7f) << shift;
      if ((next & 0x80) == 0) return value;
    }
    is_well_ = false;
    return 0;
  }
  std::uint32_t small_number() {
    const std::uint64_t value = number();
    is_well_ = is_well_ && value <= UINT32_MAX;
    return is_well_ ? static_cast<std::uint32_t>(value) : 0;
  }
  /// Takes the number of items that follow, each of at least one byte.
  std::size_t count() {
    const std::uint64_t value = number();
    is_well_ = is_well_ && value <= rest_.size();
    return is_well_ ? static_cast<std::size_t>(value) : 0;
  }
  std::span<const std::byte> take(std::size_t bytes) {
    is_well_ = is_well_ && bytes <= rest_.size();
    if (!is_well_) return {};
    const auto taken = rest_.first(bytes);
    rest_ = rest_.subspan(bytes);
    return taken;
  }
  std::string text() {
    const auto bytes = take(count());
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
  }

 private:
  std::span<const std::byte> rest_;
  bool is_well_ = true;
};

Range take_range(Reader& in) {
  Range range;
  range.begin = in.small_number();
  const std::uint32_t end = in.small_number(), step = in.small_number();
  if (step == 0) return {.begin = range.begin, .end = range.begin, .step = 1};
  range.end = end == 0 ? Range::no_end : end;
  range.step = step;
  return range;
}

Selection::Number take_number(Reader& in) {
  switch (static_cast<NumberForm>(in.byte())) {
    case NumberForm::natural:
      return in.number();
    case NumberForm::negative:
      return static_cast<std::int64_t>(~in.number());
    case NumberForm::real: {
      std::uint64_t bits = 0;
      for (int byte = 0; byte < 8; ++byte) bits |= std::uint64_t{in.byte()} << (8 * byte);
      return std::bit_cast<double>(bits);
    }
    case NumberForm::none:
      break;
  }
  in.take(SIZE_MAX);
  return std::uint64_t{0};
}

Part take_part(Reader& in) {
  Part part;
  const std::uint8_t has = in.byte();
  part.leaf = in.small_number();
  if ((has & has_rule) != 0) part.rule = in.small_number();
  if ((has & has_rows) != 0) part.rows = take_range(in);
  if ((has & has_columns) != 0) part.columns = take_range(in);
  if ((has & has_channels) != 0) {
    for (std::size_t left = in.count(); left > 0; --left) part.channels.push_back(in.text());
  }
  return part;
}

Condition take_condition(Reader& in) {
  Condition condition;
  const std::uint8_t form = in.byte();
  condition.kind = static_cast<Condition::Kind>(form & 7);
  condition.comparison = static_cast<Condition::Comparison>(form >> comparison_shift & 7);
  condition.is_percent = (form & is_percent) != 0;
  if (condition.kind == Condition::Kind::all_of || condition.kind == Condition::Kind::any_of) {
    condition.children = in.small_number();
    return condition;
  }
  for (std::size_t left = in.count(); left > 0; --left) condition.leaves.push_back(in.small_number());
  condition.number = take_number(in);
  return condition;
}

tl::unexpected<Error> malformed() {
  return fail(Errc::malformed, "these bytes are no selection, or not written as selections are");
}

}  // namespace

void detail::put(Bytes& out, const Condition& condition) {
  put_byte(out, static_cast<std::uint8_t>(static_cast<unsigned>(condition.kind) |
                                          static_cast<unsigned>(condition.comparison) << comparison_shift |
                                          (condition.is_percent ? is_percent : 0U)));
  if (condition.kind == Condition::Kind::all_of || condition.kind == Condition::Kind::any_of) {
    sft::put(out, condition.children);
    return;
  }
  sft::put(out, condition.leaves.size());
  for (const std::uint32_t leaf : condition.leaves) sft::put(out, leaf);
  sft::put(out, condition.number);
}

Bytes detail::bytes_of(std::span<const Part> parts) {
  Bytes out;
  sft::put(out, parts.size());
  for (const Part& part : parts) {
    put_byte(out, static_cast<std::uint8_t>(
                      (part.rows.is_all() ? 0 : has_rows) | (part.columns.is_all() ? 0 : has_columns) |
                      (part.channels.empty() ? 0 : has_channels) | (part.rule == 0 ? 0 : has_rule)));
    sft::put(out, part.leaf);
    if (part.rule != 0) sft::put(out, part.rule);
    if (!part.rows.is_all()) sft::put(out, part.rows);
    if (!part.columns.is_all()) sft::put(out, part.columns);
    if (part.channels.empty()) continue;
    sft::put(out, part.channels.size());
    for (const std::string& name : part.channels) sft::put(out, std::string_view(name));
  }
  return out;
}

Bytes detail::bytes_of(const Selection::Gate& gate) {
  Bytes out;
  if (!gate.conditions.empty()) sft::put(out, gate.conditions.size());
  for (const Condition& condition : gate.conditions) put(out, condition);
  if (gate.least_period.count() > 0) sft::put(out, static_cast<std::uint64_t>(gate.least_period.count()));
  return out;
}

Bytes Selection::to_bytes() const {
  Bytes out;
  put_byte(out, static_cast<std::uint8_t>((parts().empty() ? 0 : has_parts) |
                                          (gate().conditions.empty() ? 0 : has_conditions) |
                                          (gate().least_period.count() == 0 ? 0 : has_period)));
  Bytes mask;
  for (std::size_t i = 0; i < mask_.words(); ++i)
    for (int byte = 0; byte < 8; ++byte)
      put_byte(mask, static_cast<std::uint8_t>(mask_.word(i) >> (8 * byte)));
  while (!mask.empty() && mask.back() == std::byte{}) mask.pop_back();
  put(out, mask.size());
  out.insert(out.end(), mask.begin(), mask.end());
  const auto add = [&out](const Bytes& bytes) { out.insert(out.end(), bytes.begin(), bytes.end()); };
  if (!parts().empty()) add(detail::bytes_of(parts()));
  if (!gate().is_open()) add(detail::bytes_of(gate()));
  return out;
}

Result<Selection> Selection::from_bytes(std::span<const std::byte> bytes, std::size_t leaves) {
  if (bytes.size() > bytes_max) return malformed();
  Reader in(bytes);
  const std::uint8_t has = in.byte();
  const std::span<const std::byte> fields = in.take(in.count());
  std::vector<std::uint64_t> words((fields.size() + 7) / 8);
  for (std::size_t i = 0; i < fields.size(); ++i)
    words[i / 8] |= std::to_integer<std::uint64_t>(fields[i]) << (8 * (i % 8));
  std::vector<Part> parts;
  Gate gate;
  if ((has & has_parts) != 0) {
    for (std::size_t left = in.count(); left > 0 && in.is_well(); --left) parts.push_back(take_part(in));
  }
  if ((has & has_conditions) != 0) {
    for (std::size_t left = in.count(); left > 0 && in.is_well(); --left)
      gate.conditions.push_back(take_condition(in));
  }
  if ((has & has_period) != 0) {
    const std::uint64_t period = in.number();
    if (period > static_cast<std::uint64_t>(period_max.count())) return malformed();
    gate.least_period = std::chrono::microseconds(period);
  }
  if (!in.is_done()) return malformed();
  Result<Selection> selection = make(FieldMask::from_words(leaves, words), std::move(parts), std::move(gate));
  if (!selection || !std::ranges::equal(selection->to_bytes(), bytes)) return malformed();
  return selection;
}

}  // namespace sft
