// Arbitrary JSON as messages. The input is u8 number of the type (modulo their count), then the text. An
// accepted text gives a valid message. Printing that message and reading it back gives the same message.
#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

#include "sft/dynamic_view.h"
#include "sft/json.h"
#include "tests/support/message_types.h"

namespace sft::test {
namespace {

using namespace detail;

constexpr std::size_t bytes_max = 100'000, encapsulation = 4;

void require(bool condition, const char* what) {
  if (!condition) throw std::logic_error(what);  // libFuzzer reports the exception as a crash
}

std::string printed(const TypeSupport& type, const std::vector<std::byte>& cdr) {
  const FieldMask all = type.full();
  std::vector<std::uint32_t> index(type.index_slots());
  const SampleState state{.body = cdr.data() + encapsulation,
                          .body_bytes = static_cast<std::uint32_t>(cdr.size() - encapsulation),
                          .index = index.data(),
                          .mask = &all};
  require(build_index(state, type.type(), index) == WalkStatus::ok, "what is accepted is a valid message");
  const Result<std::string> text = to_json({state, type.type()});
  require(text.has_value(), "and can be printed");
  return *text;
}

void check(const TypeSupport& type, std::string_view text) {
  const auto cdr = cdr_from_json(type.type(), text, {.bytes_max = bytes_max});
  if (!cdr) {
    require(!cdr.error().message.empty(), "an error says what is wrong");
    return require(cdr.error().message.size() < 1000, "in a few words");
  }
  require(cdr->size() >= encapsulation && cdr->size() <= bytes_max + encapsulation, "as large as is allowed");
  const auto again = cdr_from_json(type.type(), printed(type, *cdr), {.bytes_max = 2 * bytes_max});
  require(again && *again == *cdr, "what is printed is the same message");
}

}  // namespace
}  // namespace sft::test

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const auto types = sft::test::all_types();
  const std::string text(reinterpret_cast<const char*>(data + 1), size - 1);
  sft::test::check(*types[data[0] % types.size()].support, text);
  return 0;
}
