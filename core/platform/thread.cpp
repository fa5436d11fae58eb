#include "core/platform/thread.h"

#include <pthread.h>
#include <sched.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <future>
#include <system_error>

namespace sft::core {

namespace {

/// Blocks signals in this thread, so that the threads that this thread starts inherit the signal mask.
class BlockedSignals {
 public:
  BlockedSignals() {
    sigset_t all;
    ::sigfillset(&all);
    // Signals that a thread causes itself stay unblocked. If they were blocked, they would end the process
    // without running its crash handler.
    for (const int fault : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGTRAP, SIGSYS, SIGABRT})
      ::sigdelset(&all, fault);
    ::pthread_sigmask(SIG_SETMASK, &all, &before_);
  }
  BlockedSignals(const BlockedSignals&) = delete;
  BlockedSignals& operator=(const BlockedSignals&) = delete;
  ~BlockedSignals() { ::pthread_sigmask(SIG_SETMASK, &before_, nullptr); }

 private:
  sigset_t before_;
};

/// A set of CPUs in the kernel's form, large enough for the maximum number of CPUs that a kernel can
/// support.
class CpuSet {
 public:
  static constexpr unsigned size = 8192;

  static CpuSet of_thread(pid_t thread) {
    CpuSet set;
    if (::sched_getaffinity(thread, sizeof set.bits_, set.bits_.data()) != 0) set = {};
    return set;
  }
  static CpuSet of(const std::vector<unsigned>& cpus) {
    CpuSet set;
    for (const unsigned cpu : cpus) CPU_SET_S(cpu, sizeof set.bits_, set.bits_.data());
    return set;
  }

  bool empty() const { return *this == CpuSet(); }
  bool contains(unsigned cpu) const { return CPU_ISSET_S(cpu, sizeof bits_, bits_.data()); }
  bool give_to_this_thread() const { return ::sched_setaffinity(0, sizeof bits_, bits_.data()) == 0; }

  friend bool operator==(const CpuSet& a, const CpuSet& b) {
    return std::memcmp(a.bits_.data(), b.bits_.data(), sizeof a.bits_) == 0;
  }

 private:
  std::array<cpu_set_t, size / CPU_SETSIZE> bits_{};
};

/// The CPUs of the program. They are read when the library is loaded, before the program can pin its threads.
/// The user may have chosen them when starting the program (taskset, a service manager), and this choice
/// applies to all threads.
const CpuSet cpus_at_start = CpuSet::of_thread(::getpid());

bool is_real_time(const ThreadSettings& settings) {
  return settings.policy != ThreadSettings::Policy::normal;
}

std::string name_of(ThreadSettings::Policy policy) {
  switch (policy) {
    case ThreadSettings::Policy::normal:
      return "normal";
    case ThreadSettings::Policy::fifo:
      return "fifo";
    case ThreadSettings::Policy::round_robin:
      return "round_robin";
  }
  return "unknown";
}

tl::unexpected<Error> refused_policy(const ThreadSettings& settings, int error) {
  const std::string priority = std::to_string(settings.priority);
  return fail(error == EPERM ? Errc::no_permission : Errc::system,
              "the system refuses the policy " + name_of(settings.policy) + " with priority " + priority +
                  ": " + std::strerror(error) +
                  "; give the program CAP_SYS_NICE, or raise its limit RLIMIT_RTPRIO to " + priority +
                  " or more (ulimit -r, or LimitRTPRIO= of its service)");
}

Result<void> take_cpus(const std::vector<unsigned>& cpus) {
  if (cpus.empty()) {
    // The CPUs that the program was started with may have been removed since then. In this case the thread
    // keeps the CPUs that it has.
    if (!cpus_at_start.empty() && cpus_at_start != CpuSet::of_thread(0))
      (void)cpus_at_start.give_to_this_thread();
    return {};
  }
  const bool given = CpuSet::of(cpus).give_to_this_thread();
  const int error = errno;
  if (!given && error != EINVAL)
    return fail(Errc::system, std::string("the system refuses the CPUs: ") + std::strerror(error));
  // The system ignores CPUs that do not exist, as long as one CPU of the set exists.
  const CpuSet granted = given ? CpuSet::of_thread(0) : CpuSet();
  for (const unsigned cpu : cpus) {
    if (!granted.contains(cpu))
      return fail(Errc::invalid_argument, "this process may not use CPU " + std::to_string(cpu) +
                                              "; see Cpus_allowed_list in /proc/self/status and lscpu");
  }
  return {};
}

Result<void> take_policy(const ThreadSettings& settings) {
  if (is_real_time(settings)) {
    const int policy = settings.policy == ThreadSettings::Policy::fifo ? SCHED_FIFO : SCHED_RR;
    const sched_param parameters{.sched_priority = settings.priority};
    if (::sched_setscheduler(0, policy, &parameters) == 0) return {};
    return refused_policy(settings, errno);
  }
  // If the inherited policy is not a real-time policy, it is the policy of the whole program, for example
  // of a batch job. So this policy is kept.
  const int inherited = ::sched_getscheduler(0);
  const sched_param parameters{.sched_priority = 0};
  if (inherited == SCHED_FIFO || inherited == SCHED_RR) ::sched_setscheduler(0, SCHED_OTHER, &parameters);
  return {};
}

/// Checks the values without system calls.
Result<void> check_values(const ThreadSettings& settings) {
  const int least = is_real_time(settings) ? 1 : 0, most = is_real_time(settings) ? 99 : 0;
  if (settings.priority < least || settings.priority > most)
    return fail(Errc::invalid_argument,
                "the priority " + std::to_string(settings.priority) +
                    " is wrong: it is 1 to 99 under the policies fifo and round_robin, "
                    "and 0 under the policy normal");
  const auto out_of_reach =
      std::ranges::find_if(settings.cpus, [](unsigned cpu) { return cpu >= CpuSet::size; });
  if (out_of_reach != settings.cpus.end())
    return fail(Errc::invalid_argument, "there is no CPU " + std::to_string(*out_of_reach));
  return {};
}

/// Returns the names of all threads once each thread has set its own name. Until a new thread has begun to
/// run and has set its name, it has the name of the thread that started it.
ThreadNames names_once_given() {
  constexpr int looks = 1000;  // there is one look per millisecond
  ThreadNames names = thread_names();
  for (int i = 0; i < looks; ++i) {
    const std::string own = names[std::to_string(::gettid())];
    if (std::ranges::count(names, own, &ThreadNames::value_type::second) <= 1) break;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    names = thread_names();
  }
  return names;
}

/// Applies the settings to this thread.
Result<void> take(const ThreadSettings& settings) {
  if (Result<void> sound = check_values(settings); !sound) return sound;
  if (Result<void> taken = take_cpus(settings.cpus); !taken) return taken;
  return take_policy(settings);
}

}  // namespace

ThreadSpec::ThreadSpec(std::string_view what, const ThreadSettings& with)
    : name((with.name_prefix.empty() ? "sft-" : with.name_prefix) + std::string(what)), settings(with) {}

Result<std::thread> start_thread(const ThreadSpec& spec, std::function<void()> body) {
  const BlockedSignals blocked;
  std::promise<Result<void>> promise;
  std::future<Result<void>> equipped = promise.get_future();
  std::thread thread;
  try {
    thread = std::thread([&spec, promise = std::move(promise), body = std::move(body)]() mutable {
      ::pthread_setname_np(::pthread_self(), spec.name.substr(0, 15).c_str());
      const Result<void> taken = take(spec.settings);
      const bool goes_on = taken.has_value();
      promise.set_value(taken);  // from here on, `spec` may already be destroyed
      if (goes_on) body();
    });
  } catch (const std::system_error& error) {
    return fail(Errc::system,
                "cannot start the thread " + spec.name + ": " + error.what() +
                    "; raise the limit on threads (RLIMIT_NPROC: ulimit -u, or TasksMax= of the "
                    "program's service)");
  }
  if (Result<void> taken = equipped.get(); !taken) {
    thread.join();
    return fail(taken.error().code, "the thread " + spec.name + ": " + taken.error().message);
  }
  return thread;
}

ThreadNames thread_names() {
  ThreadNames names;
  std::error_code ignored;
  for (const auto& thread : std::filesystem::directory_iterator("/proc/self/task", ignored))
    std::getline(std::ifstream(thread.path() / "comm"), names[thread.path().filename().string()]);
  return names;
}

void prefix_threads_since(const ThreadNames& before, const std::string& with,
                          std::span<const std::string_view> beginnings) {
  for (const auto& [thread, name] : names_once_given()) {
    const bool is_of_library = std::ranges::any_of(
        beginnings, [&text = name](std::string_view beginning) { return text.starts_with(beginning); });
    if (is_of_library && !before.contains(thread))
      std::ofstream("/proc/self/task/" + thread + "/comm") << (with + name).substr(0, 15);
  }
}

Result<void> check(const NodeOptions::Threads& threads) {
  const std::array<std::pair<const char*, const ThreadSettings*>, 5> groups{
      {{"receiver", &threads.receiver},
       {"sender", &threads.sender},
       {"agent", &threads.agent},
       {"callbacks", &threads.callbacks},
       {"discovery", &threads.discovery}}};
  std::vector<ThreadSettings> tried{ThreadSettings()};
  for (const auto& [name, settings] : groups) {
    ThreadSettings nameless = *settings;
    nameless.name_prefix.clear();
    if (std::ranges::find(tried, nameless) != tried.end()) continue;
    tried.push_back(nameless);
    Result<void> taken;
    Result<std::thread> trial = start_thread("sft-trial", [&] { taken = take(nameless); });
    if (!trial) return tl::unexpected(trial.error());
    trial->join();
    if (!taken)
      return fail(taken.error().code,
                  std::string("NodeOptions::threads.") + name + ": " + taken.error().message);
  }
  return {};
}

}  // namespace sft::core
