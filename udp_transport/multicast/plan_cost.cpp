#include "udp_transport/multicast/plan_cost.h"

#include <algorithm>
#include <cmath>

#include "udp_transport/wire/datagram.h"

namespace sft::udp {

namespace {
// The headers of Ethernet, IPv4 and UDP, which the counters of interfaces include.
constexpr double lower_header_bytes = 14 + 20 + 8;
}  // namespace

double wire_bytes(double body_bytes, std::size_t datagram_bytes, PlaceMark place) {
  const bool is_whole = body_bytes + first_header_bytes <= static_cast<double>(datagram_bytes);
  const bool has_mark = place == PlaceMark::in_group || (place == PlaceMark::in_channel && !is_whole);
  const double mark = has_mark ? group_bytes : 0;
  const bool is_single =
      place == PlaceMark::none && body_bytes + single_header_bytes <= static_cast<double>(datagram_bytes);
  const std::size_t header = is_single ? single_header_bytes : first_header_bytes;
  const double all = body_bytes + static_cast<double>(header - following_header_bytes) + mark;
  const auto room = static_cast<double>(datagram_bytes - following_header_bytes);
  const double datagrams = std::max(1.0, std::ceil(all / room));
  return all + datagrams * (static_cast<double>(following_header_bytes) + lower_header_bytes);
}

}  // namespace sft::udp
