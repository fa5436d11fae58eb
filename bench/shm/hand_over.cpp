// Measures the time from one process to another one, which spins or sleeps while it waits.
#include <linux/futex.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <atomic>

#include "bench/common/shared.h"
#include "bench/common/statistics.h"
#include "bench/common/transfer.h"
#include "bench/shm/shm.h"

namespace sft::bench {

namespace {

// The word for the measurement of the least time to wake a process: with a word in shared memory and the
// system call.

using Word = std::atomic<std::uint32_t>;

class FutexWriter : public LendingWriter {
 public:
  explicit FutexWriter(Word& word) : word_(word) {}
  std::size_t readers() const override { return 1; }
  void prepare(std::uint64_t number) override { number_ = static_cast<std::uint32_t>(number); }
  void publish() override {
    word_.store(number_, std::memory_order_release);
    syscall(SYS_futex, &word_, FUTEX_WAKE, 1, nullptr, nullptr, 0);
  }

 private:
  Word& word_;
  std::uint32_t number_ = 0;
};

class FutexReader : public Reader {
 public:
  explicit FutexReader(Word& word) : word_(word) {}
  std::size_t writers() const override { return 1; }
  void wait() override { syscall(SYS_futex, &word_, FUTEX_WAIT, seen_, nullptr, nullptr, 0); }
  std::uint64_t take() override {
    const std::uint32_t number = word_.load(std::memory_order_acquire);
    if (number == seen_) return 0;
    return seen_ = number;
  }

 private:
  Word& word_;
  std::uint32_t seen_ = 0;
};

/// Returns the times of a word in shared memory and a futex. The reader always sleeps, whatever `transfer`
/// says.
std::vector<double> raw_futex_times(const Transfer& transfer) {
  const Shared<Word> word;
  return run_pair({.sender =
                       [&](Exchange& exchange) {
                         FutexWriter writer(*word);
                         send_each(exchange, transfer, writer);
                       },
                   .receiver =
                       [&](Exchange& exchange) {
                         FutexReader reader(*word);
                         receive_each(exchange, transfer, reader);
                       }},
                  transfer.messages);
}

}  // namespace

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
