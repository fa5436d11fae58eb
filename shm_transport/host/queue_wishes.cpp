#include "shm_transport/host/queue_wishes.h"

#include <charconv>

#include "core/platform/random_id.h"

namespace sft::shm {

namespace {

// One of these marks stands between the label of a port and the id of its reader, and says what the reader
// requests. The name has room for one id only, because words of our own lie behind it (chunk_hand.h and
// queue_room.h).
constexpr std::string_view marks = "=@!*-+~^";

constexpr std::size_t late_bit = 1, awaited_bit = 2, deepest_bit = 4;  // of the position in the list of marks

}  // namespace

std::string to_text(const QueueWishes& wishes) {
  if (wishes.reader == 0) return {};
  const std::size_t mark =
      (wishes.late ? late_bit : 0) + (wishes.awaited ? awaited_bit : 0) + (wishes.deepest ? deepest_bit : 0);
  return marks[mark] + core::in_hex(wishes.reader);
}

QueueWishes parse_wishes(std::string_view port_name) noexcept {
  const auto at = port_name.find_last_of(marks);
  if (at == std::string_view::npos) return {};
  const std::string_view port_digits = port_name.substr(at + 1);
  const std::size_t mark = marks.find(port_name[at]);
  QueueWishes wishes{.late = (mark & late_bit) != 0,
                     .awaited = (mark & awaited_bit) != 0,
                     .deepest = (mark & deepest_bit) != 0};
  const auto [end, error] =
      std::from_chars(port_digits.data(), port_digits.data() + port_digits.size(), wishes.reader, 16);
  return error == std::errc{} && end == port_digits.data() + port_digits.size() ? wishes : QueueWishes{};
}

}  // namespace sft::shm
