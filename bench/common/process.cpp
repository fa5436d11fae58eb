#include "bench/common/process.h"

#include <sched.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <ctime>

namespace sft::bench {

namespace {

constexpr unsigned timeout_s = 300;

}  // namespace

void pin_to_core(int core) {
  cpu_set_t set;
  CPU_ZERO(&set);
  CPU_SET(core, &set);
  sched_setaffinity(0, sizeof set, &set);
}

pid_t start_process(const std::function<int()>& run) {
  const pid_t child = fork();
  if (child != 0) return child;
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  alarm(timeout_s);
  std::exit(run());
}

pid_t start_on_core(int core, const std::function<int()>& run) {
  return start_process([&] {
    pin_to_core(core);
    return run();
  });
}

bool succeeds(pid_t process) {
  int status = 0;
  return waitpid(process, &status, 0) == process && status == 0;
}

double cpu_s(pid_t process) {
  clockid_t clock{};
  timespec time{};
  if (clock_getcpuclockid(process, &clock) != 0) return 0;
  clock_gettime(clock, &time);
  return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_nsec) / 1e9;
}

}  // namespace sft::bench
