// A function that tests the state of the other threads of this process.
#pragma once

#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>

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

}  // namespace sft::test
