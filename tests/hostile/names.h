// The paths at which sftd and programs keep files and sockets, and functions to find and remove files and
// processes.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string>
#include <vector>

namespace sft::hostile {

/// Returns the paths that sftd uses if that account runs it (shm_transport/host/same_host.md).
std::vector<std::string> names_of(uid_t account);

/// Returns the files in /dev/shm whose names begin with `prefix`.
std::vector<std::string> shared_files(const std::string& prefix);

/// Removes a file, or a directory with its content. A path that does not exist is no error.
void remove_quietly(const std::filesystem::path& path);

/// Returns the ids of the processes that run a program file with that name.
std::vector<pid_t> processes(const std::string& program);
/// Returns the processes of the honest programs whose names begin with `name`, such as "near".
std::vector<pid_t> honest_program(const std::string& name);

}  // namespace sft::hostile
