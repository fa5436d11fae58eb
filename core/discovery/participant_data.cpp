#include "core/discovery/participant_data.h"

#include <charconv>
#include <cstddef>

#include "core/platform/random_id.h"

namespace sft::core {

namespace {

constexpr char says_secured = 's', says_topic = 't', says_asks = 'a';
constexpr std::string_view release_prefix = "sft/";
constexpr std::size_t version_digits = 4, process_digits = 16;

std::string prefix_of_this_release() {
  return std::string(release_prefix) + std::to_string(control_protocol_version()) + "/";
}

/// Returns nothing unless the whole text is a number.
template <class Number>
std::optional<Number> number_in(std::string_view text, int base) {
  Number number = 0;
  const char* const end = text.data() + text.size();
  const auto read = std::from_chars(text.data(), end, number, base);
  return read.ec == std::errc{} && read.ptr == end ? std::optional(number) : std::nullopt;
}

}  // namespace

std::string to_text(const ParticipantData& data) {
  std::string text = prefix_of_this_release() + std::to_string(data.count % 10);
  if (data.is_secured) text += says_secured;
  if (data.uses_topic) text += says_topic;
  if (data.asks) text += says_asks;
  return text + "/" + in_hex(data.process);
}

std::string user_data_in(const dds_qos_t* qos) {
  void* data = nullptr;
  std::size_t bytes = 0;
  if (!dds_qget_userdata(qos, &data, &bytes) || data == nullptr) return {};
  std::string user_data(static_cast<const char*>(data), bytes);
  dds_free(data);
  return user_data;
}

bool is_of_sft(std::string_view user_data) {
  return user_data.starts_with(release_prefix) || user_data.starts_with(vanilla_mark) ||
         user_data.find(";" + std::string(vanilla_mark)) != std::string_view::npos;
}

std::optional<ParticipantData> parse_participant_data(std::string_view user_data) {
  const std::string prefix = prefix_of_this_release();
  if (!user_data.starts_with(prefix)) return std::nullopt;
  user_data.remove_prefix(prefix.size());
  const std::size_t slash = user_data.find('/');
  if (slash == 0 || slash == std::string_view::npos) return std::nullopt;
  const std::string_view head = user_data.substr(0, slash), tail = user_data.substr(slash + 1);
  const auto count = number_in<unsigned>(head.substr(0, 1), 10);
  const auto process = number_in<ProcessId>(tail, 16);
  if (!count || !process || *process == 0 || tail.size() != process_digits) return std::nullopt;
  return ParticipantData{.process = *process,
                         .is_secured = head.find(says_secured) != std::string_view::npos,
                         .uses_topic = head.find(says_topic) != std::string_view::npos,
                         .asks = head.find(says_asks) != std::string_view::npos,
                         .count = *count};
}

std::optional<std::uint32_t> other_release(std::string_view user_data) {
  if (!user_data.starts_with(release_prefix)) return std::nullopt;
  user_data.remove_prefix(release_prefix.size());
  const std::size_t digits = user_data.find('/');
  if (digits == 0 || digits > version_digits || user_data.front() == '0') return std::nullopt;
  const auto version = number_in<std::uint32_t>(user_data.substr(0, digits), 10);
  return version && *version != control_protocol_version() ? version : std::nullopt;
}

}  // namespace sft::core
