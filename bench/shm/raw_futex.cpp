#include "bench/shm/raw_futex.h"

#include <linux/futex.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <atomic>

#include "bench/common/shared.h"

namespace sft::bench {

namespace {

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

}  // namespace

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

}  // namespace sft::bench
