// The options that all subcommands have.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace sft::tool {

struct CommonOptions {
  bool json = false;
  bool no_color = false;
  std::optional<std::uint32_t> domain{};
  std::vector<std::string> interfaces{};
  std::vector<std::string> peers{};
  std::vector<std::string> includes{};  ///< directories of packages with definitions of messages
  bool sim_time = false;                ///< the node follows /clock
  double wait_s = 1;     ///< how long a command collects what it hears before it prints a complete list
  double timeout_s = 5;  ///< how long a command waits for a topic or a sample that the user named
};

inline std::chrono::nanoseconds seconds(double s) {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::duration<double>(s));
}

}  // namespace sft::tool
