// Functions by which tests look at the threads of this process.
#pragma once

#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <set>
#include <string>

#include "tests/support/eventually.h"

namespace sft::test {

/// Returns true if all other threads of the process sleep, so that none of them is sending or receiving.
inline bool all_other_threads_sleep() {
  const std::filesystem::directory_iterator tasks("/proc/self/task");
  return std::ranges::all_of(tasks, [](const auto& task) {
    std::string line;
    std::getline(std::ifstream(task.path() / "stat"), line);
    const std::size_t behind_name = line.rfind(')');
    const bool is_this_thread = task.path().filename() == std::to_string(::gettid());
    return is_this_thread || behind_name == std::string::npos ||
           line.substr(behind_name + 1).starts_with(" S");
  });
}

/// Returns the names of all threads of the process. A new thread first has the name of the process, which
/// the main thread keeps, and then sets its own name. So this function waits until all other threads have
/// their own names. It waits for at most five seconds, since a sanitizer has a thread without a name of its
/// own.
inline std::multiset<std::string> names_of_threads() {
  const auto name_in = [](const std::filesystem::path& folder) {
    std::string name;
    std::getline(std::ifstream(folder / "comm"), name);
    return name;
  };
  const std::string of_process = name_in("/proc/self");
  std::multiset<std::string> names;
  (void)eventually(
      [&] {
        names.clear();
        for (const auto& task : std::filesystem::directory_iterator("/proc/self/task"))
          names.insert(name_in(task.path()));
        return names.count(of_process) <= 1;
      },
      std::chrono::seconds(5));
  return names;
}

}  // namespace sft::test
