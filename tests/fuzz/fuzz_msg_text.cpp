// Fuzzes from_msg() with arbitrary .msg text, which may be followed by the definitions of nested messages.
// Checks that an accepted type can be written by to_msg() and read back as the same type, and that every
// error message is one printable line.
#include <algorithm>
#include <cstdint>
#include <stdexcept>
#include <string_view>

#include "sft/msg_text.h"

namespace {

void require(bool condition, const char* what) {
  if (!condition) throw std::logic_error(what);  // libFuzzer reports the exception as a crash
}

bool is_printable(std::string_view text) {
  return std::ranges::none_of(text, [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; });
}

void check(std::string_view text) {
  constexpr const char* name = "my_msgs/Example";
  const auto type = sft::from_msg(name, text);
  if (!type) {
    require(!type.error().message.empty(), "an error says what is wrong");
    return require(is_printable(type.error().message), "and is one line");
  }
  const auto written = sft::to_msg(*type);
  require(written.has_value(), "what .msg text defined has such text");
  const auto again = sft::from_msg(name, *written);
  require(again && again->hash() == type->hash(), "of which the same type is made");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  check({reinterpret_cast<const char*>(data), size});
  return 0;
}
