// Measures SFT in shared memory with samples of two sizes, since the latency must not depend on the size.
#include "bench/common/raw_iceoryx.h"
#include "bench/common/sft_cloud.h"
#include "bench/common/statistics.h"
#include "bench/common/transfer.h"
#include "bench/spine/spine.h"

namespace sft::bench {

namespace {

constexpr std::uint32_t small_bytes = 16;

/// The contenders for one kind of reader: asleep, or spinning.
struct Contest {
  Rounds ours, ours_small, raw;

  void run(const Transfer& transfer) {
    ours.add(transfer_times<SftLoanWriter, SftReader>(transfer, sent_cloud_bytes));
    raw.add(transfer_times<RawIceoryxWriter, RawIceoryxReader>(transfer, small_bytes));
    ours_small.add(transfer_times<SftLoanWriter, SftReader>(transfer, small_bytes));
  }
};

}  // namespace

std::vector<Figure> shared_memory(const Scale& scale) {
  Contest sleeping, spinning;
  for (int round = 0; round < scale.rounds; ++round) {
    sleeping.run({.messages = scale.messages, .reading = Reading::sleeping});
    spinning.run({.messages = scale.messages, .reading = Reading::spinning});
  }
  const char* small = "the same, 16 B of data";
  return {{"shm_sleeping", sleeping.ours.p50(), "us", sleeping.raw.p50(), "iceoryx WaitSet, 16 B", 1.3},
          {"shm_spinning", spinning.ours.p50(), "us", spinning.raw.p50(), "iceoryx polling, 16 B", 2.0},
          {"shm_sleeping_size", sleeping.ours.p50(), "us", sleeping.ours_small.p50(), small, {}},
          {"shm_spinning_size", spinning.ours.p50(), "us", spinning.ours_small.p50(), small, {}}};
}

}  // namespace sft::bench
