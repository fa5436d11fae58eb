#include "from_msg/utf8.h"

namespace sft::msg {
namespace {

constexpr std::size_t longest_shown = 60;

bool is_continuation(char c) { return (static_cast<unsigned char>(c) & 0xC0) == 0x80; }

bool is_character(char32_t c) { return c <= 0x10FFFF && (c < 0xD800 || c > 0xDFFF); }

/// Returns the length of the byte sequence that begins with `lead`; 0 if no sequence begins with this byte.
std::size_t sequence_bytes(unsigned char lead) {
  if (lead < 0x80) return 1;
  if (lead >= 0xC2 && lead < 0xE0) return 2;
  if (lead >= 0xE0 && lead < 0xF0) return 3;
  return lead >= 0xF0 && lead < 0xF5 ? 4 : 0;
}

/// Returns the length in bytes of the character at the beginning of `text`; 0 if the text does not begin
/// with a valid character.
std::size_t character_bytes(std::string_view text) {
  const auto lead = static_cast<unsigned char>(text[0]);
  const std::size_t bytes = sequence_bytes(lead);
  if (bytes <= 1 || bytes > text.size()) return bytes == 1 ? 1 : 0;
  char32_t character = lead & (0xFFU >> (bytes + 1));
  for (const char c : text.substr(1, bytes - 1)) {
    if (!is_continuation(c)) return 0;
    character = character << 6 | (static_cast<unsigned char>(c) & 0x3FU);
  }
  const bool is_overlong = (bytes == 3 && character < 0x800) || (bytes == 4 && character < 0x10000);
  return is_overlong || !is_character(character) ? 0 : bytes;
}

}  // namespace

std::size_t find_invalid_utf8(std::string_view text) {
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t bytes = character_bytes(text.substr(at));
    if (bytes == 0) return at;
    at += bytes;
  }
  return std::string_view::npos;
}

bool append_utf8(char32_t c, std::string& text) {
  if (!is_character(c)) return false;
  const auto continuation = [&](int shift) { text += static_cast<char>(0x80 | (c >> shift & 0x3F)); };
  if (c < 0x80) {
    text += static_cast<char>(c);
  } else if (c < 0x800) {
    text += static_cast<char>(0xC0 | c >> 6);
    continuation(0);
  } else if (c < 0x10000) {
    text += static_cast<char>(0xE0 | c >> 12);
    continuation(6);
    continuation(0);
  } else {
    text += static_cast<char>(0xF0 | c >> 18);
    continuation(12);
    continuation(6);
    continuation(0);
  }
  return true;
}

std::string shown(std::string_view text) {
  if (text.size() <= longest_shown) return "'" + std::string(text) + "'";
  std::size_t end = longest_shown;
  while (end > 0 && is_continuation(text[end])) --end;
  return "'" + std::string(text.substr(0, end)) + "...'";
}

}  // namespace sft::msg
