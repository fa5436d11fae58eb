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
  double wait_s = 1;     ///< to look around for, where everything that is there is to be told
  double timeout_s = 5;  ///< for what was named to show up
};

inline std::chrono::nanoseconds seconds(double s) {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::duration<double>(s));
}

}  // namespace sft::tool
