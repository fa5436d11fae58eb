// Measures how costs grow with readers, masks, nodes, fields and the size of samples, beside Cyclone DDS and
// raw sockets in the same run.
// Hosts are network namespaces with an MTU of 1500. Unless a group says otherwise, the system chooses the
// cores of the processes.
#include "bench/common/program.h"
#include "bench/many/many.h"
#include "tests/support/isolated_host.h"

namespace {

void shorten(sft::bench::ManyScale& scale) {
  scale = {.quick = true, .rounds = 1, .calm_s = 10, .joining_s = 9, .window_s = 9};
}

}  // namespace

int main(int argc, char** argv) {
  using namespace sft::bench;
  ManyScale scale;
  Program program(
      "How costs grow with readers, masks, nodes, fields and sizes, against references of the same run",
      {{"bytes_masks_16", [&] { return masks_16(scale); }},
       {"masks_64",
        [&] { return masks_64(scale); },
        {"bytes_masks_64", "settled_ms", "publisher_cpu_masks_64", "publisher_cpu_masks_64_vs_raw_udp",
         "subscriber_cpu_64", "subscriber_cpu_64_vs_raw_udp"}},
       {"bytes_paper_three", [&] { return three_masks(scale); }},
       {"join_64", [&] { return join_64(scale); }, {"join_64_time", "join_64_bytes", "join_64_cpu"}},
       {"growth",
        [&] { return growth(scale); },
        {"growth_exponent_time", "growth_exponent_bytes", "growth_exponent_cpu", "growth_exponent_idle",
         "growth_exponent_newcomer"}},
       {"readers", [&] { return readers(scale); }},
       {"nodes", [&] { return nodes(scale); }},
       {"fields", [&] { return fields(scale); }},
       {"sizes", [&] { return sizes(scale); }},
       {"idle",
        [&] { return idle(scale); },
        {"idle_32_received", "idle_32_sent", "idle_32_cpu", "idle_32_rss", "idle_32_anonymous",
         "idle_2_sent"}},
       {"worst_6.3MB", [&] { return worst_large(scale); }},
       {"paced",
        [&] { return paced(scale); },
        {"paced_64B_10Hz", "paced_64B_10Hz_vs_cyclone", "paced_64B_100Hz", "paced_64B_100Hz_vs_cyclone",
         "paced_64B_1kHz", "paced_64B_1kHz_vs_cyclone", "paced_16kB", "paced_16kB_vs_raw_udp",
         "paced_cpu_10Hz", "paced_cpu_10Hz_vs_raw_udp", "paced_cpu_100Hz", "paced_cpu_100Hz_vs_raw_udp",
         "paced_cpu_1kHz", "paced_cpu_1kHz_vs_raw_udp"}},
       {"bulk",
        [&] { return bulk_without(scale); },
        {"bulk_no_offload", "bulk_no_offload_cpu", "bulk_no_offload_vs_raw_udp",
         "bulk_no_offload_cpu_vs_raw_udp", "bulk_small_buffer"}},
       {"loan_over_publish", [&] { return loans(scale); }},
       {"shm_publish", [&] { return shm_publish(scale); }, {"shm_publish_64B", "shm_publish_16kB"}},
       {"shm_wait_200Hz", [&] { return shm_wait(scale); }},
       {"response", [&] { return response(scale); }, {"str_response", "str_response_over_helpers"}},
       {"publish_to_64",
        [&] { return publish_to_64(scale); },
        {"publish_returns", "publish_returns_asynchronous", "publish_returns_others_wait",
         "masks_64_allocations"}}});
  program.options().add_flag_callback(
      "--quick", [&] { shorten(scale); }, "one short round of each contender");
  if (const auto code = program.parse(argc, argv)) return *code;
  return sft::test::run_isolated([&] { return program.run(); });
}
