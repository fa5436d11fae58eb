// Arbitrary text as masks. The input is u8 number of the type (modulo their count), then the text. An
// accepted mask is formatted, and read back as the same mask.
#include <cstdint>
#include <stdexcept>
#include <string>

#include "sft/dynamic_view.h"
#include "tests/support/message_types.h"

namespace sft::test {
namespace {

using namespace detail;

void require(bool condition, const char* what) {
  if (!condition) throw std::logic_error(what);  // libFuzzer reports the exception as a crash
}

void check_mask(const TypeSupport& type, std::string_view text) {
  const Result<FieldMask> mask = type.parse_mask(text);
  if (!mask) {
    require(mask.error().code == Errc::unknown_field, "only fields can be wrong");
    return require(!mask.error().message.empty(), "an error says what is wrong");
  }
  const Result<FieldMask> again = type.parse_mask(type.format_mask(*mask));
  require(again && *again == *mask, "what is formatted is the same mask");
  const Result<FieldMask> closed = type.parse_mask(type.format_mask(type.closed(*mask)));
  require(closed && closed->contains(*mask), "closing takes nothing away");
}

/// Checks the text as the path of one field, in a sample without any fields.
void check_path(const TypeSupport& type, std::string_view text) {
  const FieldMask none = type.none();
  const SampleState empty{.mask = &none};
  const DynamicView found = DynamicView(empty, type.type()).find(text);
  require(
      found.error() != nullptr || found.is_absent() || text.find_first_not_of('.') == std::string_view::npos,
      "nothing is there");
  require(!empty.is_malformed(), "and nothing was read");
}

}  // namespace
}  // namespace sft::test

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const auto types = sft::test::all_types();
  const std::string text(reinterpret_cast<const char*>(data + 1), size - 1);
  sft::test::check_mask(*types[data[0] % types.size()].support, text);
  sft::test::check_path(*types[data[0] % types.size()].support, text);
  return 0;
}
