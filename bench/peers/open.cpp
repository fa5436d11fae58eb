#include "bench/peers/open.h"

#include "bench/peers/pace.h"

namespace sft::bench::peers {

Contender contender_of(Way way, Where where) {
  switch (way) {
    case Way::sft_two_fields:
    case Way::sft_full:
      return where == Where::one_host ? sft_memory_peer : sft_peer;
    case Way::sft_loan:
      return sft_memory_loan_peer;
    case Way::iceoryx:
      return iceoryx_peer;
    case Way::iceoryx_loan:
      return iceoryx_loan_peer;
    case Way::cyclone:
      return cyclone_peer;
    case Way::cyclone_iceoryx:
      return cyclone_memory_peer;
    case Way::fast_dds:
      return fast_dds_peer;
    case Way::fast_dds_memory:
      return fast_dds_memory_peer;
    case Way::tcp:
      return raw_tcp_peer;
    case Way::udp:
    case Way::memcpy_alone:
      break;
  }
  return raw_udp_peer;
}

Topic topic_of(const char* name, std::size_t number, std::uint32_t bytes, const Case& of,
               const Entrant& entrant) {
  return {.name = name,
          .bulk_bytes = bytes,
          .depth = depth_of(bytes),
          .spinning = of.waiting == Waiting::spinning,
          .two_fields = entrant.way == Way::sft_two_fields,
          .spin = entrant.spin_0 ? std::optional(std::chrono::nanoseconds(0)) : std::nullopt,
          .id = static_cast<std::uint16_t>(number),
          .readers = of.readers,
          .on_one_host = of.where == Where::one_host};
}

}  // namespace sft::bench::peers
