// Removes the files in /tmp and /dev/shm that killed processes left, or that other accounts have put there.
// Only files with names of SFT are removed, and files that the daemon of iceoryx would itself replace at its
// next start.
#pragma once

#include <string>
#include <vector>

namespace sft::shm {

/// Removes the file at this path if it is a socket. Any other file, and a link to a socket, stays: a
/// process chose the name, and may have chosen the name of another file.
bool remove_socket(const std::string& path);

/// Removes the sockets of dead processes.
void remove_dead_sockets();

/// Removes the segment that the host file of a dead daemon names. This name can differ from that of this
/// daemon's segment.
void remove_segment_of_the_dead();

/// Returns the files among `files` that belong to another account and that this account may not remove.
/// Empty for root.
std::vector<std::string> files_of_others(const std::vector<std::string>& files);

/// Removes the segments, the socket and the lock files of iceoryx's daemon, and returns those that could
/// not be removed. Called before a daemon starts and when it ends, and never while another daemon lives. If
/// root runs the function, a directory that is not empty is moved aside.
std::vector<std::string> remove_daemon_files(const std::string& segment_name);

/// Returns a text that names the files in the way and their owners, and says how to remove all of them.
std::string in_the_way(const std::vector<std::string>& files);

}  // namespace sft::shm
