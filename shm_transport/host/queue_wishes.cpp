#include "shm_transport/host/queue_wishes.h"

#include <charconv>

#include "core/platform/random_id.h"

namespace sft::shm {

namespace {

// One of these marks stands between the label of a port and the id of its reader, and says what the reader
// requests. The name has room for one id only, because words of our own lie behind it (chunk_hand.h and
// queue_room.h).
constexpr char late_mark = '@', awaited_mark = '!', late_and_awaited_mark = '*';
constexpr std::string_view marks = "@!*";

}  // namespace

std::string to_text(const QueueWishes& wishes) {
  if (!wishes.late && !wishes.awaited) return {};
  const char mark = !wishes.awaited ? late_mark : !wishes.late ? awaited_mark : late_and_awaited_mark;
  return mark + core::in_hex(wishes.reader);
}

QueueWishes parse_wishes(std::string_view port_name) noexcept {
  const auto at = port_name.find_last_of(marks);
  if (at == std::string_view::npos) return {};
  const std::string_view port_digits = port_name.substr(at + 1);
  QueueWishes wishes{.late = port_name[at] != awaited_mark, .awaited = port_name[at] != late_mark};
  const auto [end, error] =
      std::from_chars(port_digits.data(), port_digits.data() + port_digits.size(), wishes.reader, 16);
  return error == std::errc{} && end == port_digits.data() + port_digits.size() ? wishes : QueueWishes{};
}

}  // namespace sft::shm
