// The options that all subcommands have.
#pragma once

#include <sft/options.h>
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
  /// Whether the node looks for nodes of DDS that know nothing of SFT. By default it always does: with
  /// `automatic`, it would discover such nodes on this host too late for a command that ends soon. `sft
  /// perf` has the default of programs instead.
  std::optional<NodeOptions::VanillaDds> dds{};
  bool sim_time = false;  ///< true: the node follows /clock
  /// The time in seconds for which a command collects announcements before it prints a complete list.
  double wait_s = 1;
  /// The maximum time in seconds for which a command waits for a topic or a sample that the user has named.
  double timeout_s = 5;
};

inline std::chrono::nanoseconds seconds(double s) {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::duration<double>(s));
}

}  // namespace sft::tool
