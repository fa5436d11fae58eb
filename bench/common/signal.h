// A semaphore of several processes. A thread that waits for it takes no processor time.
#pragma once

#include <semaphore.h>

#include <ctime>

namespace sft::bench {

class Signal {
 public:
  Signal() { sem_init(&semaphore_, 1, 0); }
  ~Signal() { sem_destroy(&semaphore_); }
  Signal(const Signal&) = delete;
  Signal& operator=(const Signal&) = delete;

  void give() { sem_post(&semaphore_); }
  void wait() {
    while (sem_wait(&semaphore_) != 0) {
    }
  }
  /// Waits for the signal. Returns false after the timeout.
  bool comes(double timeout_s) {
    timespec until{};
    clock_gettime(CLOCK_MONOTONIC, &until);
    until.tv_sec += static_cast<time_t>(timeout_s);
    return sem_clockwait(&semaphore_, CLOCK_MONOTONIC, &until) == 0;
  }

 private:
  sem_t semaphore_{};
};

}  // namespace sft::bench
