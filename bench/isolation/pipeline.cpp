#include "bench/isolation/pipeline.h"

#include <sched.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <utility>

#include "bench/common/pair.h"
#include "bench/common/process.h"

namespace sft::bench::isolation {

namespace {

constexpr std::int64_t poll_us = 10'000;
constexpr std::array topic_names{"camera", "lidar"};

Topic topic_of(const char* name, const Contender& contender) {
  constexpr std::uint32_t depth = 4;
  return {.name = name, .bulk_bytes = sent_cloud_bytes, .reliable = contender.reliable, .depth = depth};
}

/// Opens the contender with its default settings. Within the host, SFT and Fast DDS use shared memory, and
/// Cyclone DDS uses UDP. The emulated hosts have separate networks, but share one memory. A remote reader
/// must not look for samples there.
std::unique_ptr<Peer> open(Middleware middleware, bool is_remote) {
  if (middleware == Middleware::sft) return is_remote ? sft_usual_peer() : sft_local_peer();
  if (middleware == Middleware::cyclone) return cyclone_usual_peer();
  return is_remote ? fast_dds_usual_peer() : fast_dds_local_peer();
}

/// Returns the number of page faults of the calling thread so far. They show memory that its process used
/// for the first time.
std::int64_t page_faults() {
  rusage usage{};
  getrusage(RUSAGE_THREAD, &usage);
  return usage.ru_minflt;
}

[[noreturn]] void stay() {
  for (;;) pause();
}

/// Gives all other processes precedence. A real remote host has processors of its own, which this machine
/// cannot provide.
void yield_to_others() {
  const sched_param parameters{};
  sched_setscheduler(0, SCHED_IDLE, &parameters);
}

}  // namespace

Pipeline::Pipeline(const Contender& contender, std::shared_ptr<const hosts::EmulatedNetwork> network,
                   double rate_hz)
    : contender_(contender),
      period_ns_(static_cast<std::int64_t>(1e9 / rate_hz)),
      processes_(std::move(network), remote_host) {
  local_[0] = processes_.start(0, [&] { return write_all(); });
  for (std::size_t i = 0; i < local_readers; ++i)
    local_[1 + i] = processes_.start(0, [&] { return read_all(i); });
}

void Pipeline::start_remote() {
  remote_ = processes_.start(remote_host, [&] {
    yield_to_others();
    return read_all(remote_reader);
  });
}

void Pipeline::signal_remote(int signal) const { kill(remote_, signal); }

Resources Pipeline::resources() const {
  Resources used{.s = static_cast<double>(now_ns()) / 1e9};
  for (const pid_t process : local_) used.local_cpu_s += cpu_s(process);
  if (remote_ != 0) used.remote_cpu_s = cpu_s(remote_);
  return used;
}

int Pipeline::write_all() const {
  const auto peer = open(contender_.middleware, false);
  std::vector<std::unique_ptr<Writer>> writers;
  for (const char* name : topic_names) writers.push_back(peer->writer(topic_of(name, contender_)));
  const auto served = [](const auto& writer) { return writer->serves(local_readers); };
  while (!std::ranges::all_of(writers, served)) sleep_us(poll_us);
  ++board_->ready;
  while (!board_->begun.load()) sleep_us(poll_us);
  write_in_turns(writers);
  stay();
}

void Pipeline::write_in_turns(const std::vector<std::unique_ptr<Writer>>& writers) const {
  std::int64_t due_ns = now_ns();
  for (std::uint64_t n = 1; n < messages_max; ++n) {
    due_ns = next_turn_ns(due_ns, now_ns(), period_ns_);
    sleep_until(due_ns);
    board_->due_ns[n] = due_ns;
    const std::int64_t faults_before = page_faults();
    board_->sent_ns[n] = now_ns();
    board_->written = n;
    writers[n % writers.size()]->write(n);
    board_->returned_ns[n] = now_ns();
    board_->page_faults[n] = page_faults() - faults_before;
  }
}

int Pipeline::read_all(std::size_t reader) const {
  const bool is_remote = reader == remote_reader;
  const auto peer = open(contender_.middleware, is_remote);
  std::vector<std::unique_ptr<Reader>> readers;
  for (const char* name : topic_names)
    readers.push_back(peer->reader(topic_of(name, contender_), note_arrivals(reader)));
  const auto matched = [](const auto& one) { return one->writers() == 1; };
  while (!std::ranges::all_of(readers, matched)) sleep_us(poll_us);
  if (is_remote) board_->remote_matched = true;
  if (!is_remote) ++board_->ready;
  stay();
}

/// A topic's callbacks run on one thread at a time, so that no two threads note the same message.
Arrived Pipeline::note_arrivals(std::size_t reader) const {
  return [this, reader](std::uint64_t number) {
    if (number >= messages_max) return;
    std::int64_t& at = board_->arrived_ns[reader][number];
    if (at == 0) at = now_ns();
    if (reader != remote_reader) return;
    std::uint64_t latest = board_->remote_latest.load();
    while (latest < number && !board_->remote_latest.compare_exchange_weak(latest, number)) {
    }
  };
}

}  // namespace sft::bench::isolation
