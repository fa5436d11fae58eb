// Measures eight programs that sleep until the same message arrives. The writer has one core, and the
// readers share the other one. The writer sleeps after publish(), so that a thread that wakes readers on
// its behalf has a core, too.
#include <csignal>
#include <vector>

#include "bench/common/contender.h"
#include "bench/common/pair.h"
#include "bench/common/process.h"
#include "bench/common/shared.h"
#include "bench/common/statistics.h"
#include "bench/shm/shm.h"

namespace sft::bench {

namespace {

constexpr std::uint64_t readers = 8;
constexpr std::int64_t asleep_us = 300;  // the time after which all readers are asleep
constexpr std::int64_t timeout_ns = 1'000'000'000;

struct Board {
  std::atomic<std::uint64_t> ready{0};  ///< the number of readers that have begun
  std::atomic<std::uint64_t> read{0};   ///< number of messages that were read, summed over the readers
  std::int64_t sent_at[Exchange::samples_max] = {};
  std::int64_t returned_at[Exchange::samples_max] = {};
  std::atomic<std::int64_t> last_read_at[Exchange::samples_max] = {};

  void note_receipt(std::uint64_t number) {
    auto& last = last_read_at[number - 1];
    const std::int64_t now = now_ns();
    for (std::int64_t before = last; before < now && !last.compare_exchange_weak(before, now);) {
    }
    read.fetch_add(1, std::memory_order_release);
  }
  bool wait_for_all(std::uint64_t number) const {
    const std::int64_t deadline = now_ns() + timeout_ns;
    while (read.load(std::memory_order_acquire) < number * readers) {
      if (now_ns() > deadline) return false;
      sleep_us(50);
    }
    return true;
  }
};

const Topic topic{.bulk_bytes = sent_cloud_bytes, .reliable = false, .readers = readers};

bool send(Board& board, Contender contender, std::uint64_t messages) {
  const auto peer = contender();
  const auto writer = peer->writer(topic);
  if (!wait_until([&] { return board.ready.load() == readers && writer->readers() == readers; }))
    return false;
  for (std::uint64_t i = 0; i < messages; ++i) {
    pause_us(asleep_us);
    writer->prepare(i + 1);
    board.sent_at[i] = now_ns();
    writer->publish();
    board.returned_at[i] = now_ns();
    if (!board.wait_for_all(i + 1)) return false;
  }
  writer->prepare(messages + 1);  // a message with this number ends the readers
  writer->publish();
  return true;
}

void receive(Board& board, Contender contender, std::uint64_t messages) {
  const auto peer = contender();
  const auto reader = peer->reader(topic);
  while (reader->writers() == 0) sleep_us(1000);
  ++board.ready;
  for (std::uint64_t number = 0; number <= messages;) {
    reader->wait();
    number = reader->take();
    if (number != 0 && number <= messages) board.note_receipt(number);
  }
}

struct Times {
  Rounds until_returned, until_last;
};

void run(Contender contender, std::uint64_t messages, Times& times) {
  const Shared<Board> board;
  std::vector<pid_t> started;
  for (std::uint64_t i = 0; i < readers; ++i) {
    started.push_back(start_on_core(1, [&] {
      receive(*board, contender, messages);
      return 0;
    }));
  }
  const bool sent = succeeds(start_on_core(0, [&] { return send(*board, contender, messages) ? 0 : 1; }));
  for (const pid_t reader : started) {
    if (!sent) kill(reader, SIGKILL);
    succeeds(reader);
  }
  std::vector<double> until_returned, until_last;
  for (std::uint64_t i = messages / 10; sent && i < messages; ++i) {
    const std::int64_t begin = board->sent_at[i];
    until_returned.push_back(static_cast<double>(board->returned_at[i] - begin) / 1000.);
    until_last.push_back(static_cast<double>(board->last_read_at[i] - begin) / 1000.);
  }
  times.until_returned.add(std::move(until_returned));
  times.until_last.add(std::move(until_last));
}

}  // namespace

std::vector<Figure> fan_out(const Scale& scale) {
  Times ours, iceoryx;
  for (int round = 0; round < scale.rounds; ++round) {
    run(sft_cloud_loan_peer, scale.messages, ours);
    run(iceoryx_loan_peer, scale.messages, iceoryx);
  }
  const char* reference = "iceoryx, 8 WaitSets";
  return {{"publish_8_sleepers", ours.until_returned.p50(), "us", iceoryx.until_returned.p50(), reference,
           1. / 3},
          {"last_of_8", ours.until_last.p50(), "us", iceoryx.until_last.p50(), reference, 1.3}};
}

}  // namespace sft::bench
