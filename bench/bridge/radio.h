// A robot and a station with a radio link between them, and their bridges.
#pragma once

#include <sys/types.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "bench/common/host_processes.h"
#include "tools/hosts/network.h"

namespace sft::bench {

inline constexpr std::size_t robot_host = 0, station_host = 1;
inline constexpr std::uint32_t robot_domain = 41, station_domain = 42;

using Radio = std::shared_ptr<const hosts::EmulatedNetwork>;

/// Makes both hosts, and the link between them: 50 Mbit/s, with a loss of 1 % of the packets of each
/// direction. Ends the program with a message if the system does not allow it.
Radio make_radio();

/// Gives all other processes precedence. Called by programs of the station, since a real station has its
/// own processors.
void yield_to_robot();

/// Discards everything that this process prints.
void be_silent();

/// Executes a program of the project in this process. Returns an exit code if that fails.
int execute(const std::string& program, std::vector<std::string> arguments);

/// Runs the bridges of both hosts as long as this object exists. They carry "small", and x, y and z of
/// every fourth point of "points".
class Bridges {
 public:
  explicit Bridges(const Radio& radio);

  pid_t of_robot() const { return of_robot_; }
  LinkBytes link_bytes() const { return processes_.link_bytes(robot_host); }

 private:
  HostProcesses processes_;
  pid_t of_robot_ = 0;
};

}  // namespace sft::bench
