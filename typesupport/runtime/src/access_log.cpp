#include "sft/detail/access_log.h"

#include <algorithm>

namespace sft::detail {

namespace {

bool has_channel(const Selection& selection, std::size_t leaf, std::string_view name) {
  const Selection::Part* const part = selection.part(leaf);
  return part == nullptr || part->channels.empty() || std::ranges::binary_search(part->channels, name);
}

}  // namespace

std::optional<bool> AccessLog::touch_channel(std::size_t leaf, std::string_view name, bool present) noexcept {
  if (listener_ == nullptr) return {};
  const std::optional<std::size_t> number = listener_->number_of_channel(leaf, name);
  if (!number) return {};
  const bool was_sent = present && (sent_ == nullptr || has_channel(sent_->selection, leaf, name));
  touch(*number, was_sent);
  return was_sent;
}

}  // namespace sft::detail
