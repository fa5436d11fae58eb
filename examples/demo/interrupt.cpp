#include "examples/demo/interrupt.h"

#include <poll.h>
#include <signal.h>
#include <sys/signalfd.h>

#include <algorithm>

namespace sft::demo {

Interrupt::Interrupt() {
  sigset_t signals;
  sigemptyset(&signals);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&signals, signal);
  sigprocmask(SIG_BLOCK, &signals, nullptr);
  signals_ = Descriptor(signalfd(-1, &signals, SFD_CLOEXEC | SFD_NONBLOCK));
}

bool Interrupt::wait_until(Clock::time_point then) {
  for (;;) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(then - Clock::now());
    pollfd pending{.fd = signals_.get(), .events = POLLIN, .revents = 0};
    const int ready = poll(&pending, 1, static_cast<int>(std::max<std::int64_t>(left.count(), 0)));
    if (ready == 0) return false;
    signalfd_siginfo signal;
    if (ready > 0 && read(signals_.get(), &signal, sizeof signal) == sizeof signal) return true;
  }
}

}  // namespace sft::demo
