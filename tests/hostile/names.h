// The names at which sftd and programs keep files and sockets, and obstacles that can lie there.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string>
#include <vector>

namespace sft::hostile {

/// Returns the names that sftd uses if that account runs it (shm_transport/host/same_host.md).
std::vector<std::string> names_of(uid_t account);

/// Files in /dev/shm whose names begin so.
std::vector<std::string> shared_files(const std::string& prefix);

/// Removes a file, or a directory with all that is in it. A path that is not there is no error.
void remove_quietly(const std::filesystem::path& path);

/// Process ids of programs that run, by the name of the program's file.
std::vector<pid_t> processes(const std::string& program);
/// The processes of the honest programs whose names begin so: "near".
std::vector<pid_t> honest_program(const std::string& name);

}  // namespace sft::hostile
