#include "sft/detail/postponed_copies.h"

#include <cstring>
#include <functional>

namespace sft::detail {

void PostponedCopies::make(std::size_t bytes_max) noexcept {
  for (; first_ < count_ && bytes_max > 0; ++first_) {
    Copy& copy = copies_[first_];
    const std::size_t bytes = std::min(copy.bytes, bytes_max);
    std::memcpy(copy.to, copy.from, bytes);
    bytes_max -= bytes;
    copy = {copy.to + bytes, copy.from + bytes, copy.bytes - bytes};
    if (copy.bytes > 0) return;
  }
}

const std::byte* PostponedCopies::locate(const std::byte* data, std::size_t bytes) const {
  const auto is_before = std::less<const std::byte*>();
  for (const Copy& copy : std::span(copies_).subspan(first_, count_ - first_)) {
    const std::byte* const end = copy.to + copy.bytes;
    if (!is_before(data, end) || !is_before(copy.to, data + bytes)) continue;
    const bool is_within = !is_before(data, copy.to) && !is_before(end, data + bytes);
    return is_within ? copy.from + (data - copy.to) : nullptr;
  }
  return data;
}

void PostponedCopies::locate(std::span<const Segment> segments, std::vector<Segment>& located) const {
  const std::span<const Copy> copies = std::span(copies_).subspan(first_, count_ - first_);
  // Std::less also orders pointers into different memory.
  const auto is_before = std::less<const std::byte*>();
  for (Segment segment : segments) {
    const auto take = [&](const std::byte* data, std::size_t bytes) {
      if (bytes > 0) located.push_back({data, bytes});
      segment = {segment.data + bytes, segment.bytes - bytes};
    };
    for (const Copy& copy : copies) {
      const std::byte* const end = copy.to + copy.bytes;
      const bool apart = !is_before(segment.data, end) || !is_before(copy.to, segment.data + segment.bytes);
      if (apart) continue;
      if (is_before(segment.data, copy.to))
        take(segment.data, static_cast<std::size_t>(copy.to - segment.data));
      const auto within = static_cast<std::size_t>(segment.data - copy.to);
      take(copy.from + within, std::min(segment.bytes, copy.bytes - within));
    }
    take(segment.data, segment.bytes);
  }
}

}  // namespace sft::detail
