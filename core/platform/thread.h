// Starts all threads of a node. The threads have names for debuggers, never get the signals of the process,
// and have the CPUs and the scheduling policy of their settings, even if the starting thread has others. If
// the system cannot start another thread, the result is an error and not an exception.
#pragma once

#include <functional>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <thread>
#include <utility>

#include "sft/options.h"
#include "sft/result.h"

namespace sft::core {

struct ThreadSpec {
  std::string name;  ///< the first 15 characters are used
  ThreadSettings settings{};

  ThreadSpec(const char* full_name) : name(full_name) {}
  ThreadSpec(std::string full_name) : name(std::move(full_name)) {}
  /// Makes the name of the thread from the prefix of the settings and `what`.
  ThreadSpec(std::string_view what, const ThreadSettings& with);
};

/// Starts a thread, and returns once its settings are in effect. Returns an error if the system refuses a
/// setting.
Result<std::thread> start_thread(const ThreadSpec& spec, std::function<void()> body);

/// The names of threads, by their thread ids as text.
using ThreadNames = std::map<std::string, std::string>;
/// Returns the names of all threads of this process.
ThreadNames thread_names();
/// Puts the prefix before the names of threads that a library has started since `before` was read. These are
/// the threads whose names begin with one of `beginnings`. Other threads that the program has started
/// meanwhile keep their names.
void prefix_threads_since(const ThreadNames& before, const std::string& prefix,
                          std::span<const std::string_view> beginnings);

/// Checks the settings of each group of threads by trying them. The error names the option that is invalid
/// or that the system refuses.
Result<void> check(const NodeOptions::Threads& threads);

}  // namespace sft::core
