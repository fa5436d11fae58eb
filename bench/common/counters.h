// Counts the work of the threads of a process, for example while a sample passes. The counts do not depend
// on the speed of the machine or on other programs.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace sft::bench {

/// The work of a thread or of a process so far. System calls that this machine cannot count are missing.
struct Counts {
  std::optional<std::int64_t> system_calls{};
  /// The number of calls of each system call that is counted separately, by name.
  std::map<std::string, std::int64_t> calls{};
  /// Number of times that the thread slept until it was woken (voluntary switches).
  std::int64_t wake_ups = 0;
  std::int64_t preemptions = 0;  ///< number of times that another thread ran instead (involuntary switches)
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

/// Counts the work of a process from the construction of the counter on. Only the threads that exist at
/// that time are counted.
class ProcessCounter {
 public:
  /// `process` may be the calling process. The caller needs the right to trace that process. To count
  /// system calls, the caller needs root's rights.
  explicit ProcessCounter(pid_t process);
  ~ProcessCounter();
  ProcessCounter(ProcessCounter&&) noexcept;
  ProcessCounter& operator=(ProcessCounter&&) noexcept;

  std::vector<ThreadCounts> read() const;
  /// Returns false if threads have been started or have ended since the construction; read() does not count
  /// these threads.
  bool same_threads() const;
  /// Returns the reason if system calls cannot be counted on this machine or by this user.
  const std::vector<std::string>& uncountable() const { return uncountable_; }

 private:
  struct Thread;

  pid_t process_;
  std::vector<Thread> threads_;
  std::vector<std::string> uncountable_;
};

}  // namespace sft::bench
