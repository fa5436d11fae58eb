#include "core/platform/quotes.h"

#include <array>
#include <cstdint>

namespace sft::core {

namespace {

constexpr std::size_t quoted_bytes_max = 64;

/// Returns true for the control characters C0, DEL and C1, and for other characters that cause a line
/// break.
bool is_control(char32_t code) {
  return code < 0x20 || (code >= 0x7f && code < 0xa0) || code == 0x2028 || code == 0x2029;
}

/// Returns true for marks that change the direction of the text that follows. Such marks could disguise
/// this text.
bool turns_text_around(char32_t code) {
  return (code >= 0x202a && code <= 0x202e) || (code >= 0x2066 && code <= 0x2069);
}

std::string escaped(std::string_view bytes) {
  constexpr std::string_view digits = "0123456789abcdef";
  std::string text;
  for (const char c : bytes) {
    const auto byte = static_cast<std::uint8_t>(c);
    text += {'\\', 'x', digits[byte >> 4], digits[byte & 15]};
  }
  return text;
}

}  // namespace

Character first_of(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<std::uint8_t>(text[i]); };
  const std::uint8_t lead = byte(0);
  if (lead < 0x80) return {1, lead};
  const std::size_t bytes = lead >= 0xf0 ? 4 : lead >= 0xe0 ? 3 : 2;
  if (lead < 0xc2 || lead > 0xf4 || text.size() < bytes) return {};
  char32_t code = lead & (0xffU >> (bytes + 1));
  for (std::size_t i = 1; i < bytes; ++i) {
    if ((byte(i) & 0xc0) != 0x80) return {};
    code = code << 6 | (byte(i) & 0x3fU);
  }
  constexpr std::array<char32_t, 5> least{0, 0, 0x80, 0x800, 0x10000};  // codes below these values need fewer
                                                                        // bytes
  const bool is_surrogate = code >= 0xd800 && code <= 0xdfff;
  if (code < least[bytes] || code > 0x10ffff || is_surrogate) return {};
  return {bytes, code};
}

bool acts_on_terminals(char32_t code) { return is_control(code) || turns_text_around(code); }

std::string in_quotes(std::string_view text) {
  std::string out = "'";
  std::size_t left = text.size();
  while (left > 0 && out.size() <= quoted_bytes_max) {
    const std::string_view rest = text.substr(text.size() - left);
    const Character c = first_of(rest);
    const bool plain = c.bytes != 0 && !acts_on_terminals(c.code);
    const std::size_t bytes = c.bytes == 0 ? 1 : c.bytes;
    out += plain ? std::string(rest.substr(0, bytes)) : escaped(rest.substr(0, bytes));
    left -= bytes;
  }
  if (left > 0) return out + "...' (" + std::to_string(text.size()) + " bytes)";
  return out + "'";
}

}  // namespace sft::core
