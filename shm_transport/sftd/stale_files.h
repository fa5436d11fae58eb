// What killed processes left behind in /tmp and /dev/shm, and what other accounts have put there. Only names
// that are SFT's, or that iceoryx's daemon would itself replace at its next start.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace sft::shm {

/// Removes what lies at this path if it is a socket itself, not a link to one: a name that a process chose
/// may be that of another file.
bool remove_socket(const std::string& path);

/// Sockets of dead processes; returns how many.
std::size_t remove_dead_sockets();

/// The segment of a dead daemon that left its sign: it may have had another name than this one's.
void remove_segment_of_the_dead();

/// Those of these files that belong to another account, and may not be removed by this one. Empty for root.
std::vector<std::string> files_of_others(const std::vector<std::string>& files);

/// Removes segments, socket and lock files of a daemon, and returns those that could not be removed. Called
/// before one starts and when one ends: never while one lives. Root moves a directory that is not empty out
/// of the way.
std::vector<std::string> remove_daemon_files(const std::string& segment_name);

/// Says what is in the way and whose it is, and how to remove all of it.
std::string in_the_way(const std::vector<std::string>& files);

}  // namespace sft::shm
