#include "bench/common/pair.h"

#include <csignal>
#include <ctime>

#include "bench/common/process.h"
#include "bench/common/shared.h"

namespace sft::bench {

bool Exchange::wait_for_receipt(std::uint64_t n) {
  const std::int64_t deadline = now_ns() + 1'000'000'000;
  while (received.load(std::memory_order_acquire) < n) {
    if (now_ns() > deadline || failed.load()) return false;
  }
  return true;
}

void Exchange::note_receipt(std::uint64_t n) {
  received_at[n - 1] = now_ns();
  received.store(n, std::memory_order_release);
}

void pause_us(std::int64_t us) {
  const std::int64_t until = now_ns() + us * 1000;
  while (now_ns() < until) {
  }
}

void sleep_us(std::int64_t us) {
  const timespec time{us / 1'000'000, us % 1'000'000 * 1000};
  nanosleep(&time, nullptr);
}

void sleep_until(std::int64_t ns) {
  const timespec time{ns / 1'000'000'000, ns % 1'000'000'000};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &time, nullptr) != 0) {
  }
}

bool wait_until(const std::function<bool()>& holds, double timeout_s) {
  const std::int64_t deadline = now_ns() + static_cast<std::int64_t>(timeout_s * 1e9);
  while (!holds()) {
    if (now_ns() > deadline) return false;
    sleep_us(1000);
  }
  return true;
}

namespace {

pid_t start(int core, const std::function<void()>& enter, const std::function<void(Exchange&)>& role,
            Exchange& exchange) {
  return start_on_core(core, [&] {
    enter();
    role(exchange);
    return exchange.failed.load() ? 1 : 0;
  });
}

}  // namespace

std::vector<Delivery> run_deliveries(const Sides& sides, std::uint64_t messages) {
  const Shared<Exchange> exchange;
  const pid_t receiver = start(1, sides.enter_receiver, sides.receiver, *exchange);
  const pid_t sender = start(0, sides.enter_sender, sides.sender, *exchange);
  const bool sent = succeeds(sender);
  if (!sent) kill(receiver, SIGKILL);
  succeeds(receiver);
  std::vector<Delivery> deliveries;
  for (std::uint64_t i = 0; sent && i < messages; ++i)
    deliveries.push_back({exchange->sent_at[i], exchange->received_at[i], exchange->returned_at[i]});
  return deliveries;
}

std::vector<double> run_pair(const Sides& sides, std::uint64_t messages) {
  const std::vector<Delivery> deliveries = run_deliveries(sides, messages);
  std::vector<double> times;
  for (std::size_t i = messages / 10; i < deliveries.size(); ++i) {
    if (deliveries[i].received_at != 0) times.push_back(deliveries[i].us());
  }
  return times;
}

}  // namespace sft::bench
