// Measures the transfer of 6.3 MB from one program to another one, which sleeps until the data arrive: with
// SFT as a cloud, and with other middleware as samples in its shared memory.
#include <algorithm>

#include "bench/common/roudi.h"
#include "bench/common/statistics.h"
#include "bench/common/transfer.h"
#include "bench/shm/shm.h"

namespace sft::bench {

namespace {

// Bound of a loan, relative to a standard message of the other contenders.
constexpr double loan_bound = 1. / 10;
// Bound of a loan, relative to the other contenders' loans of fixed size.
constexpr double fixed_bound = 1. / 3;
// Bound of publish(message), relative to a standard message of the other contenders.
constexpr double owned_bound = 1 / 1.5;

}  // namespace

std::vector<Figure> clouds(const Scale& scale) {
  const Transfer transfer{.messages = std::max<std::uint64_t>(scale.messages / 8, 100)};
  const Topic topic{.bulk_bytes = sent_cloud_bytes, .reliable = false};
  const Roudi roudi;
  const auto cyclone_times = [&](Contender contender) {
    return called_times(
        contender, topic, transfer, [&] { roudi.enter(); }, iceoryx_connecting_us);
  };
  Rounds loan, owned, cyclone, cyclone_loan, fast, fast_loan;
  for (int round = 0; round < scale.rounds; ++round) {
    loan.add(transfer_times(sft_cloud_loan_peer, topic, transfer));
    cyclone.add(cyclone_times(cyclone_memory_peer));
    fast.add(called_times(fast_dds_memory_peer, topic, transfer));
    owned.add(transfer_times(sft_cloud_peer, topic, transfer));
    cyclone_loan.add(cyclone_times(cyclone_memory_loan_peer));
    fast_loan.add(called_times(fast_dds_memory_loan_peer, topic, transfer));
  }
  return {
      {"cloud_6.3MB_vs_cyclone", loan.p50(), "us", cyclone.p50(), "Cyclone over iceoryx", loan_bound},
      {"cloud_6.3MB_vs_cyclone_fixed", loan.p50(), "us", cyclone_loan.p50(), "its loan of fixed size",
       fixed_bound},
      {"cloud_6.3MB_owned_vs_cyclone", owned.p50(), "us", cyclone.p50(), "Cyclone over iceoryx", owned_bound},
      {"cloud_6.3MB_vs_fastdds", loan.p50(), "us", fast.p50(), "Fast DDS, shared memory", loan_bound},
      {"cloud_6.3MB_vs_fastdds_fixed", loan.p50(), "us", fast_loan.p50(), "its loan, data sharing",
       fixed_bound},
      {"cloud_6.3MB_owned_vs_fastdds", owned.p50(), "us", fast.p50(), "Fast DDS, shared memory",
       owned_bound}};
}

}  // namespace sft::bench
