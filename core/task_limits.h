// How many threads this process may still start, as the files of the system tell.
#pragma once

#include <sys/resource.h>

#include <cstdint>
#include <filesystem>
#include <optional>

namespace sft::core {

/// The least that any limit leaves: that of the user, of the control groups (cgroups(7), pids.max), and of
/// the system (proc(5), threads-max and pid_max). All threads of the system count as the user's, so it may be
/// less than there are. Empty where a file cannot be read. `root` is where /proc and /sys are.
std::optional<std::uint64_t> threads_left(rlim_t of_user, const std::filesystem::path& root = "/");

}  // namespace sft::core
