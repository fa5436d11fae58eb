#include "bench/common/pair.h"

#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <ctime>

#include "bench/common/shared.h"

namespace sft::bench {

bool Exchange::wait_for_receipt(std::uint64_t n) {
  const std::int64_t deadline = now_ns() + 1'000'000'000;
  while (received.load(std::memory_order_acquire) < n) {
    if (now_ns() > deadline || failed.load()) return false;
  }
  return true;
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

void pin_to_core(int core) {
  cpu_set_t set;
  CPU_ZERO(&set);
  CPU_SET(core, &set);
  sched_setaffinity(0, sizeof set, &set);
}

namespace {

constexpr unsigned patience_s = 300;  // a side that takes longer hangs

pid_t start(int core, const std::function<void()>& enter, const std::function<void(Exchange&)>& role,
            Exchange& exchange) {
  const pid_t child = fork();
  if (child != 0) return child;
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  enter();
  pin_to_core(core);
  alarm(patience_s);
  role(exchange);
  std::exit(exchange.failed.load() ? 1 : 0);
}

}  // namespace

std::vector<double> run_pair(const Sides& sides, std::uint64_t messages) {
  const Shared<Exchange> exchange;
  const pid_t receiver = start(1, sides.enter_receiver, sides.receiver, *exchange);
  const pid_t sender = start(0, sides.enter_sender, sides.sender, *exchange);
  int status = 0;
  waitpid(sender, &status, 0);
  if (status != 0) kill(receiver, SIGKILL);
  waitpid(receiver, nullptr, 0);
  std::vector<double> times;
  for (std::uint64_t i = messages / 10; status == 0 && i < messages; ++i) {
    if (exchange->received_at[i] != 0) {
      times.push_back(static_cast<double>(exchange->received_at[i] - exchange->sent_at[i]) / 1000.0);
    }
  }
  return times;
}

}  // namespace sft::bench
