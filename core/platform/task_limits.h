// Determines the number of threads that this process may still start, from files of the system.
#pragma once

#include <sys/resource.h>

#include <cstdint>
#include <filesystem>
#include <optional>

namespace sft::core {

/// Returns the number of threads that can still be started within all limits: the user's limit `of_user`,
/// the limits of the control groups (cgroups(7), pids.max), and those of the system (proc(5), threads-max
/// and pid_max). The function counts all threads of the system against the user's limit, so the true number
/// may be greater. Returns nothing if a file cannot be read. `root` is the directory that contains proc and
/// sys.
std::optional<std::uint64_t> threads_left(rlim_t of_user, const std::filesystem::path& root = "/");

}  // namespace sft::core
