#include "core/discovery/participant_mark.h"

#include <charconv>

#include "sft_control.h"

namespace sft::core {

namespace {

constexpr char secured = 's', complaint_begins = '!';
constexpr std::string_view hex_digits = "0123456789abcdef";

constexpr std::string_view name_prefix = "sft/";
constexpr std::size_t version_digits_max = 4;

std::string version_prefix() {
  return std::string(name_prefix) + std::to_string(sft_control_protocol_version) + "/";
}

std::optional<Participants::Guid> parse_guid(std::string_view text) {
  Participants::Guid guid{};
  if (text.size() != 2 * guid.size()) return std::nullopt;
  for (std::size_t i = 0; i < guid.size(); ++i) {
    const char* const end = text.data() + 2 * i + 2;
    const auto read = std::from_chars(end - 2, end, guid[i], 16);
    if (read.ec != std::errc{} || read.ptr != end) return std::nullopt;
  }
  return guid;
}

}  // namespace

std::string to_text(const ParticipantMark& mark) {
  std::string text = version_prefix() + std::to_string(mark.greeting % 10);
  if (mark.is_secured) text += secured;
  for (const Participants::Guid& guid : mark.complaints) {
    text += complaint_begins;
    for (const std::uint8_t byte : guid) {
      text += hex_digits[byte >> 4];
      text += hex_digits[byte & 15];
    }
  }
  return text;
}

std::optional<ParticipantMark> parse_participant_mark(std::string_view user_data) {
  const std::string prefix = version_prefix();
  if (!user_data.starts_with(prefix)) return std::nullopt;
  user_data.remove_prefix(prefix.size());
  ParticipantMark mark;
  if (!user_data.empty() && user_data.front() >= '0' && user_data.front() <= '9')
    mark.greeting = static_cast<unsigned>(user_data.front() - '0');
  mark.is_secured = user_data.size() > 1 && user_data[1] == secured;
  for (std::size_t begin = user_data.find(complaint_begins);
       begin != std::string_view::npos && mark.complaints.size() < complaints_max;) {
    const std::size_t end = user_data.find(complaint_begins, begin + 1);
    const std::string_view text =
        user_data.substr(begin + 1, end == std::string_view::npos ? end : end - begin - 1);
    if (const auto guid = parse_guid(text)) mark.complaints.push_back(*guid);
    begin = end;
  }
  return mark;
}

std::optional<std::uint32_t> other_version(std::string_view user_data) {
  if (!user_data.starts_with(name_prefix)) return std::nullopt;
  user_data.remove_prefix(name_prefix.size());
  const std::size_t length = user_data.find('/');
  if (length == 0 || length > version_digits_max || user_data.front() == '0') return std::nullopt;
  std::uint32_t version = 0;
  const auto read = std::from_chars(user_data.data(), user_data.data() + length, version);
  const bool is_number = read.ec == std::errc{} && read.ptr == user_data.data() + length;
  return is_number && version != sft_control_protocol_version ? std::optional(version) : std::nullopt;
}

}  // namespace sft::core
