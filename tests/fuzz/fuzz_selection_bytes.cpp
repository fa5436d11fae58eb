// Arbitrary bytes as selections. The input is u8 leaves of the type, u16 bytes of a selection
// (little-endian), this selection, and another one. An accepted selection is written as the same bytes, and
// obeys the laws of union.
#include <algorithm>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <vector>

#include "sft/selection.h"

namespace sft {
namespace {

void require(bool condition, const char* what) {
  if (!condition) throw std::logic_error(what);  // libFuzzer reports the exception as a crash
}

/// Reads a selection from memory of exactly the size of `bytes`, so that the address sanitizer notices the
/// first byte beyond it.
Result<Selection> checked(std::span<const std::byte> bytes, std::size_t leaves) {
  const std::vector<std::byte> copy(bytes.begin(), bytes.end());
  Result<Selection> selection = Selection::from_bytes(copy, leaves);
  if (!selection) {
    require(selection.error().code == Errc::malformed, "bytes are malformed, if anything");
    return selection;
  }
  require(selection->to_bytes() == copy, "what is accepted is written in the same way");
  require(selection->mask().leaves() == leaves, "it is of the type");
  require(selection->parts().size() <= Selection::parts_max, "there are not too many parts");
  require(selection->gate().conditions.size() <= Selection::conditions_max, "nor too many conditions");
  for (const Selection::Part& part : selection->parts())
    require(selection->mask().contains(part.leaf) && !part.is_whole(), "a part is of a field, and not whole");
  return selection;
}

void check_alone(const Selection& one) {
  require(one.joined(one) == one, "joining with itself changes nothing");
  require(one.without_gate().what_hash() == one.what_hash(), "the gate is no field");
  require((one.gate_hash() == 0) == one.gate().is_open(), "an open gate has no hash");
  require(one.with_gate(one.gate()).value() == one, "its gate is a gate");
}

void check_pair(const Selection& a, const Selection& b) {
  const Selection both = a.joined(b);
  require(both == b.joined(a), "the order of joining does not matter");
  require(Selection::from_bytes(both.to_bytes(), both.mask().leaves()).has_value(), "it can be sent");
  for (const Selection& one : {a, b})
    require(one.joined(both).without_gate() == both.without_gate(), "what is in it adds nothing");
  if (a == b) require(a.what_hash() == b.what_hash() && a.gate_hash() == b.gate_hash(), "hashes are equal");
}

void check(std::span<const std::byte> input) {
  if (input.size() < 3) return;
  const auto byte = [&input](std::size_t at) { return std::to_integer<std::size_t>(input[at]); };
  const std::size_t leaves = byte(0), first_bytes = byte(1) + 256 * byte(2);
  const auto rest = input.subspan(3);
  const auto first = rest.first(std::min(first_bytes, rest.size()));
  const Result<Selection> a = checked(first, leaves), b = checked(rest.subspan(first.size()), leaves);
  if (a) check_alone(*a);
  if (b) check_alone(*b);
  if (a && b) check_pair(*a, *b);
}

}  // namespace
}  // namespace sft

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  sft::check(std::as_bytes(std::span(data, size)));
  return 0;
}
