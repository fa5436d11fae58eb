// Counts what the threads of a process do, for example while a sample passes. These counts do not depend on
// how fast the machine is, or on what else runs there.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace sft::bench {

/// The work of a thread or of a process so far. A count that this machine cannot measure is missing.
struct Counts {
  std::optional<std::int64_t> instructions{};  ///< those of the program, and of the kernel for it
  std::optional<std::int64_t> cache_misses{};
  std::optional<std::int64_t> system_calls{};
  std::map<std::string, std::int64_t> calls{};  ///< the system calls that are counted by name
  std::int64_t wake_ups = 0;     ///< how often the thread slept until it was woken (voluntary switches)
  std::int64_t preemptions = 0;  ///< how often other threads ran instead (involuntary switches)
  std::int64_t cpu_ns = 0;

  Counts& operator+=(const Counts& other);
  /// Returns the counts since `before`.
  Counts since(const Counts& before) const;
};

struct ThreadCounts {
  pid_t thread = 0;
  std::string name;
  Counts counts{};
};

/// Returns the sum over all threads.
Counts sum_of(const std::vector<ThreadCounts>& threads);

/// Counts the work of those threads that a process has when the counter is made, from then on.
class ProcessCounter {
 public:
  /// `process` may be the calling process. The caller needs the right to trace it. To count system calls and
  /// the work of the kernel, it needs root's rights.
  explicit ProcessCounter(pid_t process);
  ~ProcessCounter();
  ProcessCounter(ProcessCounter&&) noexcept;
  ProcessCounter& operator=(ProcessCounter&&) noexcept;

  std::vector<ThreadCounts> read() const;
  /// Returns false if threads have been started or have ended, which read() does not count.
  bool same_threads() const;
  /// Names each count that is not available on this machine or to this user, with the reason.
  const std::vector<std::string>& uncountable() const { return uncountable_; }

 private:
  struct Thread;

  pid_t process_;
  std::vector<Thread> threads_;
  std::vector<std::string> uncountable_;
};

}  // namespace sft::bench
