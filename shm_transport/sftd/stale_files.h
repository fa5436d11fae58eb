// What killed processes left behind in /tmp and /dev/shm. Only names that are SFT's, or that iceoryx's daemon
// would itself replace at its next start.
#pragma once

#include <cstddef>
#include <string>

namespace sft::shm {

/// Removes what lies at this path if it is a socket itself, not a link to one: a name that a process chose
/// may be that of another file.
bool remove_socket(const std::string& path);

/// Sockets of dead processes; returns how many.
std::size_t remove_dead_sockets();

/// The segment of a dead daemon that left its sign: it may have had another name than this one's.
void remove_segment_of_the_dead();

/// Segments, socket and lock files of a daemon. Called before one starts and when one ends: never while one
/// lives.
void remove_daemon_files(const std::string& segment_name);

}  // namespace sft::shm
