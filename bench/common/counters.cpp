#include "bench/common/counters.h"

#include <fcntl.h>
#include <linux/perf_event.h>
#include <sys/ioctl.h>
#include <sys/mount.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <numeric>
#include <utility>

#include "core/platform/file_descriptor.h"

namespace sft::bench {

namespace {

using core::FileDescriptor;

/// The system calls that wait, wake or pass data.
constexpr std::array<std::pair<const char*, int>, 18> named_calls{{{"futex", SYS_futex},
                                                                   {"io_uring_enter", SYS_io_uring_enter},
                                                                   {"epoll_wait", SYS_epoll_wait},
                                                                   {"epoll_pwait", SYS_epoll_pwait},
                                                                   {"poll", SYS_poll},
                                                                   {"ppoll", SYS_ppoll},
                                                                   {"select", SYS_select},
                                                                   {"pselect6", SYS_pselect6},
                                                                   {"recvfrom", SYS_recvfrom},
                                                                   {"recvmsg", SYS_recvmsg},
                                                                   {"recvmmsg", SYS_recvmmsg},
                                                                   {"sendto", SYS_sendto},
                                                                   {"sendmsg", SYS_sendmsg},
                                                                   {"sendmmsg", SYS_sendmmsg},
                                                                   {"read", SYS_read},
                                                                   {"write", SYS_write},
                                                                   {"clock_nanosleep", SYS_clock_nanosleep},
                                                                   {"sched_yield", SYS_sched_yield}}};

struct EventType {
  std::uint32_t type = 0;
  std::uint64_t config = 0;
};

/// Returns a counter of one event in one thread. If the event is not available, the counter is not valid,
/// and errno gives the reason.
FileDescriptor open_event(const EventType& event, pid_t thread) {
  perf_event_attr attributes{};
  attributes.size = sizeof attributes;
  attributes.type = event.type;
  attributes.config = event.config;
  return FileDescriptor(
      static_cast<int>(syscall(SYS_perf_event_open, &attributes, thread, -1, -1, PERF_FLAG_FD_CLOEXEC)));
}

/// Opens the directory of the kernel's events. If its file system is not mounted, mounts it for this
/// process only.
FileDescriptor open_tracefs() {
  FileDescriptor mounted(open("/sys/kernel/tracing", O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (mounted && faccessat(mounted.get(), "events", F_OK, 0) == 0) return mounted;
  const FileDescriptor context(fsopen("tracefs", FSOPEN_CLOEXEC));
  if (!context || fsconfig(context.get(), FSCONFIG_CMD_CREATE, nullptr, nullptr, 0) != 0) return {};
  return FileDescriptor(fsmount(context.get(), FSMOUNT_CLOEXEC, 0));
}

/// Returns the event for the beginning of a system call.
std::optional<EventType> system_call_event() {
  const FileDescriptor events = open_tracefs();
  if (!events) return std::nullopt;
  const FileDescriptor file(openat(events.get(), "events/raw_syscalls/sys_enter/id", O_RDONLY | O_CLOEXEC));
  if (!file) return std::nullopt;
  std::array<char, 32> text{};
  if (read(file.get(), text.data(), text.size() - 1) <= 0) return std::nullopt;
  return EventType{PERF_TYPE_TRACEPOINT, std::strtoull(text.data(), nullptr, 10)};
}

std::optional<std::int64_t> value_of(const FileDescriptor& counter) {
  std::int64_t value = 0;
  if (!counter || read(counter.get(), &value, sizeof value) != sizeof value) return std::nullopt;
  return value;
}

std::filesystem::path tasks_of(pid_t process) { return "/proc/" + std::to_string(process) + "/task"; }

std::vector<pid_t> threads_of(pid_t process) {
  std::vector<pid_t> threads;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(tasks_of(process), error))
    threads.push_back(std::stoi(entry.path().filename()));
  std::ranges::sort(threads);
  return threads;
}

std::int64_t number_behind(const std::string& key, std::istream& lines) {
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with(key)) return std::stoll(line.substr(key.size()));
  }
  return 0;
}

/// Reads the counts that the kernel maintains for each thread in any case.
Counts noted(const std::filesystem::path& task) {
  std::ifstream status(task / "status");
  Counts counts;
  counts.wake_ups = number_behind("voluntary_ctxt_switches:", status);
  counts.preemptions = number_behind("nonvoluntary_ctxt_switches:", status);
  std::ifstream(task / "schedstat") >> counts.cpu_ns;
  return counts;
}

const char* reason(int error) {
  const bool missing = error == ENOENT || error == ENODEV || error == EOPNOTSUPP;
  return missing ? "this machine has no such counter" : std::strerror(error);
}

std::optional<std::int64_t> sum(std::optional<std::int64_t> a, std::optional<std::int64_t> b) {
  return a && b ? std::optional(*a + *b) : std::nullopt;
}

}  // namespace

Counts& Counts::operator+=(const Counts& other) {
  system_calls = sum(system_calls, other.system_calls);
  for (const auto& [name, times] : other.calls) calls[name] += times;
  wake_ups += other.wake_ups;
  preemptions += other.preemptions;
  cpu_ns += other.cpu_ns;
  return *this;
}

Counts Counts::since(const Counts& before) const {
  Counts negative;
  const auto minus = [](std::optional<std::int64_t> n) { return n ? std::optional(-*n) : n; };
  negative.system_calls = minus(before.system_calls);
  for (const auto& [name, times] : before.calls) negative.calls[name] = -times;
  negative.wake_ups = -before.wake_ups;
  negative.preemptions = -before.preemptions;
  negative.cpu_ns = -before.cpu_ns;
  Counts counts = *this;
  return counts += negative;
}

Counts sum_of(const std::vector<ThreadCounts>& threads) {
  if (threads.empty()) return {};
  return std::accumulate(threads.begin() + 1, threads.end(), threads.front().counts,
                         [](Counts sum, const ThreadCounts& thread) { return sum += thread.counts; });
}

struct ProcessCounter::Thread {
  pid_t number = 0;
  FileDescriptor system_calls{};
  std::vector<std::pair<const char*, FileDescriptor>> calls{};
  Counts before{};

  void count_system_calls(const EventType& event) {
    system_calls = open_event(event, number);
    for (const auto& [name, call] : named_calls) {
      FileDescriptor counter = open_event(event, number);
      const std::string filter = "id == " + std::to_string(call);
      if (counter && ioctl(counter.get(), PERF_EVENT_IOC_SET_FILTER, filter.c_str()) == 0)
        calls.emplace_back(name, std::move(counter));
    }
  }
  Counts counts(const std::filesystem::path& task) const {
    Counts counts = noted(task);
    counts.system_calls = value_of(system_calls);
    for (const auto& [name, counter] : calls) counts.calls[name] = value_of(counter).value_or(0);
    return counts;
  }
};

ProcessCounter::ProcessCounter(pid_t process) : process_(process) {
  const auto event = system_call_event();
  const int no_event = errno;
  const auto note = [&](const char* what, bool counted, int error) {
    const std::string line = std::string(what) + ": " + reason(error);
    if (!counted && std::ranges::find(uncountable_, line) == uncountable_.end()) uncountable_.push_back(line);
  };
  for (const pid_t number : threads_of(process)) {
    Thread& thread = threads_.emplace_back(Thread{.number = number});
    if (event) thread.count_system_calls(*event);
    note("system calls", static_cast<bool>(thread.system_calls), event ? errno : no_event);
  }
  for (Thread& thread : threads_)
    thread.before = thread.counts(tasks_of(process) / std::to_string(thread.number));
}

ProcessCounter::~ProcessCounter() = default;
ProcessCounter::ProcessCounter(ProcessCounter&&) noexcept = default;
ProcessCounter& ProcessCounter::operator=(ProcessCounter&&) noexcept = default;

std::vector<ThreadCounts> ProcessCounter::read() const {
  std::vector<ThreadCounts> threads;
  for (const Thread& thread : threads_) {
    const std::filesystem::path task = tasks_of(process_) / std::to_string(thread.number);
    ThreadCounts& counted = threads.emplace_back(ThreadCounts{.thread = thread.number, .name = {}});
    std::getline(std::ifstream(task / "comm"), counted.name);
    counted.counts = thread.counts(task).since(thread.before);
  }
  return threads;
}

bool ProcessCounter::same_threads() const {
  return std::ranges::equal(threads_of(process_), threads_, {}, {}, &Thread::number);
}

}  // namespace sft::bench
