// Measures SFT in shared memory with samples of two sizes, since latency must not depend on the size.
#include "bench/common/statistics.h"
#include "bench/common/transfer.h"
#include "bench/spine/spine.h"

namespace sft::bench {

namespace {

const Topic small{.bulk_bytes = 16, .reliable = false};
const Topic large{.bulk_bytes = sent_cloud_bytes, .reliable = false};

/// The contenders for one kind of reader, which sleeps or spins.
struct Contest {
  Rounds ours, ours_small, raw;

  void run(const Transfer& transfer) {
    ours.add(transfer_times(sft_cloud_loan_peer, large, transfer));
    raw.add(transfer_times(iceoryx_loan_peer, small, transfer));
    ours_small.add(transfer_times(sft_cloud_loan_peer, small, transfer));
  }
};

}  // namespace

std::vector<Figure> shared_memory(const Scale& scale) {
  Contest sleeping, spinning;
  for (int round = 0; round < scale.rounds; ++round) {
    sleeping.run({.messages = scale.messages, .reading = Reading::sleeping});
    spinning.run({.messages = scale.messages, .reading = Reading::spinning});
  }
  const char* of_small = "the same, 16 B of data";
  return {{"shm_sleeping", sleeping.ours.p50(), "us", sleeping.raw.p50(), "iceoryx WaitSet, 16 B", 1.3},
          {"shm_spinning", spinning.ours.p50(), "us", spinning.raw.p50(), "iceoryx polling, 16 B", 2.0},
          {"shm_sleeping_size", sleeping.ours.p50(), "us", sleeping.ours_small.p50(), of_small, {}},
          {"shm_spinning_size", spinning.ours.p50(), "us", spinning.ours_small.p50(), of_small, {}}};
}

}  // namespace sft::bench
