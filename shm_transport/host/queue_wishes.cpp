#include "shm_transport/host/queue_wishes.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <optional>

#include "core/platform/random_id.h"

namespace sft::shm {

namespace {

// One of these characters stands between the label of a port and the id of its reader, and encodes the
// reader's requests. The name has space for one id only, because words of our own are stored after the name
// (chunk_hand.h and queue_room.h).
constexpr std::string_view marks = "=@!*-+~^";

// Bits of a character's position in `marks`.
constexpr std::size_t late_bit = 1, awaited_bit = 2, deepest_bit = 4;

// The letters that can follow the digits of the id. Each letter stands for a limit of bytes, which is a
// power of two.
constexpr char first_letter = 'g', last_letter = 'z';
constexpr int least_power = 16, greatest_power = least_power + (last_letter - first_letter);

char letter_of(std::uint64_t bytes_max) {
  const int power = std::clamp(static_cast<int>(std::bit_width(bytes_max)) - 1, least_power, greatest_power);
  return static_cast<char>(first_letter + power - least_power);
}

std::optional<std::uint64_t> bytes_of(char letter) {
  if (letter < first_letter || letter > last_letter) return std::nullopt;
  return std::uint64_t{1} << (least_power + letter - first_letter);
}

}  // namespace

std::string to_text(const QueueWishes& wishes) {
  if (wishes.reader == 0) return {};
  const std::size_t mark =
      (wishes.late ? late_bit : 0) + (wishes.awaited ? awaited_bit : 0) + (wishes.deepest ? deepest_bit : 0);
  std::string text = marks[mark] + core::in_hex(wishes.reader);
  if (wishes.bytes_max != 0) text += letter_of(wishes.bytes_max);
  return text;
}

QueueWishes parse_wishes(std::string_view port_name) noexcept {
  const auto at = port_name.find_last_of(marks);
  if (at == std::string_view::npos) return {};
  std::string_view port_digits = port_name.substr(at + 1);
  const auto bytes_max = port_digits.empty() ? std::nullopt : bytes_of(port_digits.back());
  if (bytes_max) port_digits.remove_suffix(1);
  const std::size_t mark = marks.find(port_name[at]);
  QueueWishes wishes{.late = (mark & late_bit) != 0,
                     .awaited = (mark & awaited_bit) != 0,
                     .deepest = (mark & deepest_bit) != 0,
                     .bytes_max = bytes_max.value_or(0)};
  const auto [end, error] =
      std::from_chars(port_digits.data(), port_digits.data() + port_digits.size(), wishes.reader, 16);
  return error == std::errc{} && end == port_digits.data() + port_digits.size() ? wishes : QueueWishes{};
}

}  // namespace sft::shm
