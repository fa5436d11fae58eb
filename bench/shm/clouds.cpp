// Measures a 6.3 MB cloud from one program to another one, which sleeps until the cloud comes: with SFT, and
// with the shared memory of other middleware.
#include <algorithm>

#include "bench/common/roudi.h"
#include "bench/common/sft_cloud.h"
#include "bench/common/statistics.h"
#include "bench/shm/cyclone_cloud.h"
#include "bench/shm/fast_dds_cloud.h"
#include "bench/shm/shm.h"

namespace sft::bench {

namespace {

constexpr double loan_bound = 1. / 10;   // times the standard message of others
constexpr double fixed_bound = 1. / 3;   // times their loans of fixed size
constexpr double owned_bound = 1 / 1.5;  // times the standard message of others

}  // namespace

std::vector<Figure> clouds(const Scale& scale) {
  const Transfer transfer{.messages = std::max<std::uint64_t>(scale.messages / 8, 100)};
  const Roudi roudi;
  Rounds loan, owned, cyclone, cyclone_loan, fast, fast_loan;
  for (int round = 0; round < scale.rounds; ++round) {
    loan.add(transfer_times<SftLoanWriter, SftReader>(transfer, sent_cloud_bytes));
    cyclone.add(cyclone_standard(transfer, roudi));
    fast.add(fast_dds_standard(transfer));
    owned.add(transfer_times<SftOwnedWriter, SftReader>(transfer, sent_cloud_bytes));
    cyclone_loan.add(cyclone_fixed(transfer, roudi));
    fast_loan.add(fast_dds_fixed(transfer));
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
