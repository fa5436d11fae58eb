#include "bench/peers/trial.h"

#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <memory>
#include <string>

#include "bench/common/contest.h"
#include "bench/common/process.h"
#include "bench/common/shared.h"
#include "bench/peers/board.h"
#include "bench/peers/sender.h"

namespace sft::bench::peers {

namespace {

/// Opens the contender that the entrant measures. REQUIRES: this contender has readers.
std::unique_ptr<Peer> open(const Trial& trial) {
  const Contender sft = trial.of.where == Where::one_host ? sft_memory_peer : sft_peer;
  const Contender contenders[] = {sft,
                                  sft,
                                  sft_memory_loan_peer,
                                  iceoryx_peer,
                                  iceoryx_loan_peer,
                                  cyclone_peer,
                                  cyclone_memory_peer,
                                  fast_dds_peer,
                                  fast_dds_memory_peer,
                                  raw_tcp_peer,
                                  raw_udp_peer};
  return contenders[static_cast<std::size_t>(trial.entrant.way)]();
}

/// Returns the topic for messages of the size with this index.
Topic topic_of(const Trial& trial, std::size_t number) {
  const std::uint32_t bytes = trial.sizes[number];
  Topic topic{.name = "bytes" + std::to_string(bytes),
              .bulk_bytes = bytes,
              .depth = depth_of(bytes),
              .spinning = trial.of.waiting == Waiting::spinning,
              .two_fields = trial.entrant.way == Way::sft_two_fields,
              .id = static_cast<std::uint16_t>(number),
              .readers = trial.of.readers,
              .on_one_host = trial.of.where == Where::one_host};
  if (trial.entrant.spin_0) topic.spin = std::chrono::nanoseconds(0);
  return topic;
}

/// Copies each message, and then notes its receipt for all readers.
class CopyingWriter : public Writer {
 public:
  CopyingWriter(Board& board, std::size_t size, const Trial& trial)
      : board_(board), size_(size), readers_(trial.of.readers), from_(trial.sizes[size], std::byte{1}) {}

  std::size_t readers() const override { return readers_; }
  void write(std::uint64_t number) override {
    std::memcpy(to_.data(), from_.data(), from_.size());
    clobber_memory();
    for (std::size_t i = 0; i < readers_; ++i) board_.readers[i].receipts[size_].note(number);
  }

 private:
  Board& board_;
  const std::size_t size_, readers_;
  const std::vector<std::byte> from_;
  std::vector<std::byte> to_ = from_;
};

int measure_all(Board& board, const std::vector<std::unique_ptr<Writer>>& writers, const Trial& trial) {
  for (std::size_t i = 0; i < writers.size(); ++i) {
    if (!Sender(board, *writers[i], i, trial.of, trial.pace).measure()) return 1;
  }
  return 0;
}

int copy_all(Board& board, const Trial& trial) {
  std::vector<std::unique_ptr<Writer>> writers;
  for (std::size_t i = 0; i < trial.sizes.size(); ++i)
    writers.push_back(std::make_unique<CopyingWriter>(board, i, trial));
  return measure_all(board, writers, trial);
}

int write_all(Board& board, const Trial& trial) {
  const auto peer = open(trial);
  std::vector<std::unique_ptr<Writer>> writers;
  for (std::size_t i = 0; i < trial.sizes.size(); ++i) writers.push_back(peer->writer(topic_of(trial, i)));
  const auto ready = [&] {
    return board.ready.load() == trial.of.readers &&
           std::ranges::all_of(writers, [&](const auto& w) { return w->readers() == trial.of.readers; });
  };
  if (!wait_until(ready)) return 1;
  if (trial.entrant.way == Way::cyclone_iceoryx) sleep_us(iceoryx_connecting_us);
  return measure_all(board, writers, trial);
}

/// Reads messages of one size until the last message has arrived.
void read(Reader& reader, Receipts& receipts, const std::atomic<std::uint64_t>& last_number) {
  while (receipts.last.load() < last_number.load()) {
    reader.wait();
    while (const std::uint64_t number = reader.take()) receipts.note(number);
  }
}

int read_all(Board& board, const Trial& trial, std::size_t number) {
  const auto peer = open(trial);
  std::vector<std::unique_ptr<Reader>> readers;
  for (std::size_t i = 0; i < trial.sizes.size(); ++i) {
    Topic topic = topic_of(trial, i);
    topic.reader = number;
    readers.push_back(peer->reader(topic));
  }
  for (const auto& reader : readers) {
    while (reader->writers() == 0) sleep_us(1000);
  }
  ReaderNotes& notes = board.readers[number];
  notes.process = getpid();
  ++board.ready;
  for (std::size_t i = 0; i < readers.size(); ++i) {
    read(*readers[i], notes.receipts[i], board.last_number[i]);
    notes.sizes_done = i + 1;
  }
  return 0;
}

/// Runs all processes to their end. Returns false if one of them failed.
bool run_processes(Board& board, const Trial& trial, const Stage& stage) {
  if (trial.entrant.way == Way::memcpy_alone)
    return succeeds(start_on_core(0, [&] { return copy_all(board, trial); }));
  std::vector<pid_t> readers;
  for (std::size_t i = 0; i < trial.of.readers; ++i) {
    readers.push_back(start_on_core(1, [&] {
      stage.enter_as_reader(trial.of, trial.entrant.way, i);
      return read_all(board, trial, i);
    }));
  }
  bool succeeded = succeeds(start_on_core(0, [&] {
    stage.enter_as_writer(trial.entrant.way);
    return write_all(board, trial);
  }));
  for (const pid_t reader : readers) {
    if (!succeeded) kill(reader, SIGKILL);
    succeeded = succeeds(reader) && succeeded;
  }
  return succeeded;
}

Record record_of(const SizeResult& result, const Trial& trial, std::uint32_t bytes) {
  Record record{.of = trial.of,
                .entrant = trial.entrant,
                .bytes = bytes,
                .paced_cpu_us = result.paced_cpu_us,
                .per_s = result.per_s,
                .fast_cpu_us = result.fast_cpu_us,
                .lost = result.lost};
  set_latency(record, {result.times_us, result.times_us + result.samples});
  return record;
}

}  // namespace

Records run(const Trial& trial, const Stage& stage) {
  const Shared<Board> board;
  if (!run_processes(*board, trial, stage)) {
    std::fprintf(stderr, "  %s failed\n", name_of(trial.entrant).c_str());
    return {};
  }
  Records records;
  for (std::size_t i = 0; i < trial.sizes.size(); ++i)
    records.push_back(record_of(board->results[i], trial, trial.sizes[i]));
  return records;
}

}  // namespace sft::bench::peers
