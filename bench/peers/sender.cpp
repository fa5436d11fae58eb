#include "bench/peers/sender.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>

#include "bench/common/process.h"

namespace sft::bench::peers {

namespace {

constexpr std::int64_t timeout_ns = 2'000'000'000;
constexpr std::int64_t look_again_us = 50;
constexpr std::size_t warm_up_min = 5;
constexpr double warm_up_s = 0.1;
// A rate is computed from at least this number of messages, if they arrive in time.
constexpr std::uint64_t received_min = 8;
constexpr double timeout_of_rate_s = 1;
constexpr std::int64_t quiet_us = 50'000;  // if no message arrives for this time, no more will arrive

std::int64_t ns_of(double seconds) { return static_cast<std::int64_t>(seconds * 1e9); }

}  // namespace

Sender::Sender(Board& board, Writer& writer, std::size_t size, const Case& of, const Pace& pace)
    : board_(board), writer_(writer), size_(size), of_(of), pace_(pace), result_(board.results[size]) {}

bool Sender::measure() {
  warm_up();
  measure_latency();
  measure_throughput();
  count_lost();
  return finish();
}

Sender::Moment Sender::moment() const {
  double cpu = cpu_s(getpid());
  for (std::size_t i = 0; i < of_.readers; ++i) {
    if (const pid_t reader = board_.readers[i].process.load(); reader != 0) cpu += cpu_s(reader);
  }
  return {now_ns(), received(), cpu};
}

std::uint64_t Sender::received() const {
  std::uint64_t least = number_;
  for (std::size_t i = 0; i < of_.readers; ++i)
    least = std::min(least, board_.readers[i].receipts[size_].count.load());
  return least;
}

std::uint64_t Sender::last_received() const {
  std::uint64_t least = number_;
  for (std::size_t i = 0; i < of_.readers; ++i)
    least = std::min(least, board_.readers[i].receipts[size_].last.load(std::memory_order_acquire));
  return least;
}

std::int64_t Sender::received_at_ns(std::uint64_t number) const {
  std::int64_t latest = 0;
  for (std::size_t i = 0; i < of_.readers; ++i)
    latest = std::max(latest, board_.readers[i].receipts[size_].at_ns[number % samples_max]);
  return latest;
}

double Sender::send_and_wait() {
  const std::int64_t sent_at_ns = now_ns();
  writer_.write(++number_);
  const std::int64_t due_ns = sent_at_ns + pace_.period_us * 1000;
  while (now_ns() < due_ns || last_received() < number_) {
    const std::int64_t now = now_ns();
    if (now > sent_at_ns + timeout_ns) return unknown;
    if (sleeps()) sleep_us(std::max(look_again_us, (due_ns - now) / 1000));
  }
  return static_cast<double>(received_at_ns(number_) - sent_at_ns) / 1000;
}

void Sender::warm_up() {
  const std::int64_t end_ns = now_ns() + ns_of(warm_up_s);
  for (std::size_t i = 0; i < pace_.warm_up && (i < warm_up_min || now_ns() < end_ns); ++i) send_and_wait();
}

void Sender::measure_latency() {
  const Moment begin = moment();
  const std::int64_t end_ns = begin.at_ns + ns_of(pace_.latency_s);
  std::size_t sent = 0;
  for (; sent < pace_.samples && (sent < pace_.samples_min || now_ns() < end_ns); ++sent) {
    const double us = send_and_wait();
    if (std::isfinite(us)) result_.times_us[result_.samples++] = us;
  }
  result_.paced_cpu_us = 1e6 * (moment().cpu_s - begin.cpu_s) / static_cast<double>(sent);
}

void Sender::send_for(double seconds) {
  const std::uint64_t received_before = received();
  const std::int64_t end_ns = now_ns() + ns_of(seconds), latest_ns = end_ns + ns_of(timeout_of_rate_s);
  for (std::int64_t now = now_ns();
       now < end_ns || (received() < received_before + received_min && now < latest_ns); now = now_ns())
    writer_.write(++number_);
}

void Sender::measure_throughput() {
  send_for(pace_.throughput_warm_up_s);
  const Moment begin = moment();
  send_for(pace_.throughput_s);
  const Moment end = moment();
  const auto received = static_cast<double>(end.received - begin.received);
  if (received == 0) return;
  result_.per_s = 1e9 * received / static_cast<double>(end.at_ns - begin.at_ns);
  result_.fast_cpu_us = 1e6 * (end.cpu_s - begin.cpu_s) / received;
}

void Sender::count_lost() {
  for (std::uint64_t before = ~0ull; before != received() && received() < number_;) {
    before = received();
    sleep_us(quiet_us);
  }
  result_.lost = static_cast<double>(number_ - received()) / static_cast<double>(number_);
}

/// Readers wait for a message, so only a message can end them. The last message is sent again in case it
/// was lost.
bool Sender::finish() {
  constexpr int tries = 5;
  board_.last_number[size_] = number_ + 1;
  for (int i = 0; i < tries; ++i) {
    writer_.write(++number_);
    const auto done = [&] {
      return std::all_of(board_.readers, board_.readers + of_.readers, [&](const ReaderNotes& reader) {
        return reader.process == 0 || reader.sizes_done > size_;
      });
    };
    if (wait_until(done, 2)) return true;
  }
  return false;
}

}  // namespace sft::bench::peers
