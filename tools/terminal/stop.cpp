#include "tools/terminal/stop.h"

#include <poll.h>
#include <signal.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <ctime>

namespace sft::tool {

using Clock = std::chrono::steady_clock;

Stop::Stop() {
  sigset_t signals;
  sigemptyset(&signals);
  for (const int number : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&signals, number);
  sigprocmask(SIG_BLOCK, &signals, nullptr);
  signals_ = signalfd(-1, &signals, SFD_CLOEXEC | SFD_NONBLOCK);
}

Stop::~Stop() { close(signals_); }

bool Stop::requested() const { return requested_; }

void Stop::request() { requested_ = true; }

void Stop::look() {
  signalfd_siginfo info;
  if (read(signals_, &info, sizeof info) == sizeof info) requested_ = true;
}

bool Stop::wait_for(std::chrono::nanoseconds time, int descriptor) {
  const auto now = Clock::now();
  const auto end = time < std::chrono::hours(10'000) ? now + time : now + std::chrono::hours(10'000);
  look();
  while (!requested_) {
    const auto left = std::max<std::chrono::nanoseconds>(end - Clock::now(), std::chrono::nanoseconds(0));
    const auto seconds = std::chrono::floor<std::chrono::seconds>(left);
    const timespec pause{seconds.count(), (left - seconds).count()};
    std::array<pollfd, 2> watched{{{signals_, POLLIN, 0}, {descriptor, POLLIN, 0}}};
    const int ready = ppoll(watched.data(), watched.size(), &pause, nullptr);
    if (ready < 0 && errno != EINTR) break;
    if (watched[0].revents != 0) look();
    if (watched[1].revents != 0 || ready == 0) break;
  }
  return requested_;
}

}  // namespace sft::tool
