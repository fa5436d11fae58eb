// Counts what the threads of a process do, for example while a sample passes: what they take does not depend
// on how fast the machine is, or on what else runs there.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace sft::bench {

/// The work of a thread or of a process so far. A count that this machine does not have is missing.
struct Counts {
  std::optional<std::int64_t> instructions{};  ///< of the program and of the kernel on its behalf
  std::optional<std::int64_t> cache_misses{};
  std::optional<std::int64_t> system_calls{};
  std::map<std::string, std::int64_t> calls{};  ///< those system calls that are counted by name
  std::int64_t wake_ups = 0;     ///< how often the thread slept until something woke it (voluntary switches)
  std::int64_t preemptions = 0;  ///< how often others ran instead (involuntary switches)
  std::int64_t cpu_ns = 0;

  Counts& operator+=(const Counts& other);
  /// The counts since `before`.
  Counts since(const Counts& before) const;
};

struct ThreadCounts {
  pid_t thread = 0;
  std::string name;
  Counts counts{};
};

/// The sum over all threads.
Counts sum_of(const std::vector<ThreadCounts>& threads);

/// Counts the threads that a process has when the counter is made, from then on.
class ProcessCounter {
 public:
  /// The calling process may be the one that is counted. It needs the right to trace the process, and for
  /// system calls and all that the kernel does, root's rights.
  explicit ProcessCounter(pid_t process);
  ~ProcessCounter();
  ProcessCounter(ProcessCounter&&) noexcept;
  ProcessCounter& operator=(ProcessCounter&&) noexcept;

  std::vector<ThreadCounts> read() const;
  /// False if threads have come or gone, of which read() knows nothing.
  bool same_threads() const;
  /// Names each count that this machine or this user cannot have, with the reason.
  const std::vector<std::string>& uncountable() const { return uncountable_; }

 private:
  struct Thread;

  pid_t process_;
  std::vector<Thread> threads_;
  std::vector<std::string> uncountable_;
};

}  // namespace sft::bench
