// Measures the way from one process to another one, which spins or sleeps while it waits.
#include "bench/common/statistics.h"
#include "bench/common/transfer.h"
#include "bench/shm/raw_futex.h"
#include "bench/shm/shm.h"

namespace sft::bench {

std::vector<Figure> hand_over(const Scale& scale) {
  const Transfer spinning{.messages = scale.messages, .reading = Reading::spinning};
  const Transfer sleeping{.messages = scale.messages, .reading = Reading::sleeping};
  const Topic cloud{.bulk_bytes = sent_cloud_bytes, .reliable = false};
  Rounds ours_spinning, iceoryx_spinning, ours, iceoryx, futex;
  for (int round = 0; round < scale.rounds; ++round) {
    ours_spinning.add(transfer_times(sft_cloud_loan_peer, cloud, spinning));
    iceoryx_spinning.add(transfer_times(iceoryx_loan_peer, cloud, spinning));
    ours.add(transfer_times(sft_cloud_loan_peer, cloud, sleeping));
    iceoryx.add(transfer_times(iceoryx_loan_peer, cloud, sleeping));
    futex.add(raw_futex_times(sleeping));
  }
  return {{"spinning", ours_spinning.p50(), "us", iceoryx_spinning.p50(), "iceoryx polling", 1.5},
          {"spinning_p99", ours_spinning.p99(), "us", iceoryx_spinning.p99(), "iceoryx polling", {}},
          {"sleeping", ours.p50(), "us", iceoryx.p50(), "iceoryx WaitSet", 1.0},
          {"sleeping_p99", ours.p99(), "us", iceoryx.p99(), "iceoryx WaitSet", {}},
          {"sleeping_vs_futex", ours.p50(), "us", futex.p50(), "raw futex", 1.15}};
}

std::vector<Figure> size_flatness(const Scale& scale) {
  struct Size {
    const char* name;
    std::uint32_t bytes;
    Rounds times{};
  };
  std::vector<Size> sizes = {
      {"16B", 16}, {"16KiB", 16 << 10}, {"1MiB", 1 << 20}, {"6.3MB", sent_cloud_bytes}};
  const Transfer transfer{.messages = scale.messages, .reading = Reading::spinning, .preparing_counts = true};
  for (int round = 0; round < scale.rounds; ++round) {
    for (Size& size : sizes)
      size.times.add(transfer_times(sft_cloud_loan_peer, {.bulk_bytes = size.bytes}, transfer));
  }
  std::vector<Figure> figures;
  for (const Size& size : sizes) {
    figures.push_back({std::string("size_flatness_") + size.name, size.times.p50(), "us",
                       sizes.front().times.p50(), "16 B of data, spinning", 1.2});
  }
  return figures;
}

}  // namespace sft::bench
