#include "bench/isolation/pipeline.h"

#include <sched.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <utility>

#include "bench/common/pair.h"
#include "bench/common/process.h"

namespace sft::bench::isolation {

namespace {

constexpr std::int64_t poll_us = 10'000;

/// The page faults of the calling thread so far: memory that its process uses for the first time.
std::int64_t page_faults() {
  rusage usage{};
  getrusage(RUSAGE_THREAD, &usage);
  return usage.ru_minflt;
}

[[noreturn]] void stay() {
  for (;;) pause();
}

/// Lets all other processes run first. The remote host has processors of its own in reality, which this
/// machine cannot have.
void yield_to_others() {
  const sched_param parameters{};
  sched_setscheduler(0, SCHED_IDLE, &parameters);
}

}  // namespace

Pipeline::Pipeline(const Contender& contender, std::shared_ptr<const hosts::EmulatedNetwork> network,
                   double rate_hz)
    : contender_(contender),
      period_ns_(static_cast<std::int64_t>(1e9 / rate_hz)),
      crowd_(std::move(network), remote_host) {
  local_[0] = crowd_.start(0, [&] { return write_all(); });
  for (std::size_t i = 0; i < local_readers; ++i)
    local_[1 + i] = crowd_.start(0, [&] { return read_all(i); });
}

void Pipeline::start_remote() {
  remote_ = crowd_.start(remote_host, [&] {
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
  const auto writer = open_writer(contender_);
  while (!writer->serves(local_readers)) sleep_us(poll_us);
  ++board_->ready;
  while (!board_->begun.load()) sleep_us(poll_us);
  write_in_turns(*writer);
  stay();
}

void Pipeline::write_in_turns(Writer& writer) const {
  std::int64_t due_ns = now_ns();
  for (std::uint64_t n = 1; n < messages_max; ++n) {
    due_ns = next_turn_ns(due_ns, now_ns(), period_ns_);
    sleep_until(due_ns);
    board_->due_ns[n] = due_ns;
    const std::int64_t faults_before = page_faults();
    board_->sent_ns[n] = now_ns();
    board_->written = n;
    writer.write(n);
    board_->returned_ns[n] = now_ns();
    board_->page_faults[n] = page_faults() - faults_before;
  }
}

int Pipeline::read_all(std::size_t reader) const {
  const Place place = reader == remote_reader ? Place::remote : Place::local;
  const auto opened = open_reader(contender_, place, note_arrivals(reader));
  while (!opened->is_matched()) sleep_us(poll_us);
  if (place == Place::remote) board_->remote_matched = true;
  if (place == Place::local) ++board_->ready;
  stay();
}

/// One thread at a time calls back for a topic, so that no two threads note the same message.
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
