// Arbitrary text as selections. The input is u8 number of the type (modulo their count), then the text. An
// accepted selection is formatted, and read back as the same selection. An error names a column of the text.
#include <charconv>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <string_view>

#include "sft/selection.h"
#include "tests/support/message_types.h"

namespace sft::test {
namespace {

void require(bool condition, const char* what) {
  if (!condition) throw std::logic_error(what);  // libFuzzer reports the exception as a crash
}

void check_error(const Error& error, std::size_t text_bytes) {
  require(error.code == Errc::unknown_field || error.code == Errc::invalid_argument ||
              error.code == Errc::limit_exceeded,
          "texts have errors of these kinds only");
  const std::string_view message = error.message;
  constexpr std::string_view begin = "column ";
  require(message.starts_with(begin), "an error begins with the column");
  std::size_t column = 0;
  const char* const digits = message.data() + begin.size();
  const auto [end, fault] = std::from_chars(digits, message.data() + message.size(), column);
  require(fault == std::errc() && column >= 1 && column <= text_bytes + 1, "the column is in the text");
  const std::string_view rest = message.substr(static_cast<std::size_t>(end - message.data()));
  require(rest.starts_with(": ") && rest.size() > 2, "an error says what is wrong");
}

void check_selection(const TypeSupport& type, std::string_view text) {
  const Result<Selection> selection = type.parse_selection(text);
  if (const Result<FieldMask> mask = type.parse_mask(text))
    require(selection && *selection == Selection(*mask), "what a mask is means the same as a selection");
  if (!selection) return check_error(selection.error(), text.size());
  const std::string formatted = type.format_selection(*selection);
  const Result<Selection> again = type.parse_selection(formatted);
  require(again && *again == *selection, "what is formatted is the same selection");
  require(type.format_selection(*again) == formatted, "a selection is formatted in one way");
  const Result<Selection> sent = Selection::from_bytes(selection->to_bytes(), type.leaves());
  require(sent && *sent == *selection, "what is sent is the same selection");
  require(sent->what_hash() == selection->what_hash() && sent->gate_hash() == selection->gate_hash(),
          "equal selections have equal hashes");
}

}  // namespace
}  // namespace sft::test

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const auto types = sft::test::all_types();
  const std::string text(reinterpret_cast<const char*>(data + 1), size - 1);
  sft::test::check_selection(*types[data[0] % types.size()].support, text);
  return 0;
}
