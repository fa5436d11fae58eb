#include "udp_transport/reliable/length_watch.h"

#include <algorithm>
#include <utility>

namespace sft::udp {

namespace {
/// True if the sample was sent, and does not fit into one datagram of that length.
bool is_long(const ResendWindow& window, std::uint64_t ordinal, std::size_t length) {
  const auto bytes = window.bytes_sent(ordinal);
  return bytes && *bytes + following_header_bytes > length;
}
}  // namespace

LengthWatch::Verdict LengthWatch::judge(const Ack& ack, const ResendWindow& window, std::size_t length,
                                        bool is_in_doubt) {
  if (std::exchange(length_, length) != length) sent_so_from_ = window.end();
  const bool arrived = is_in_doubt && some_arrived(ack, window);
  const auto lacks_all = [&](const Missing& part) {
    if (part.ordinal != static_cast<std::uint32_t>(ack.next) || !is_long(window, ack.next, length))
      return false;
    return part.begin == 0 && (part.end == 0 || part.end + length > *window.bytes_sent(ack.next));
  };
  return {.arrived = arrived, .lost = std::ranges::any_of(ack.parts(), lacks_all)};
}

/// True if the ack tells of a long sample for the first time.
bool LengthWatch::some_arrived(const Ack& ack, const ResendWindow& window) {
  const std::uint64_t end = std::min(ack.next, window.end());
  bool arrived = false;
  for (std::uint64_t n = std::max(sent_so_from_, window.begin()); n < end && !arrived; ++n)
    arrived = is_long(window, n, length_);
  sent_so_from_ = std::max(sent_so_from_, end);
  return arrived;
}

}  // namespace sft::udp
