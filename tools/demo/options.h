// The options of the command line.
#pragma once

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <optional>

namespace sft::demo {

struct DemoOptions {
  std::optional<std::filesystem::path> input{};  ///< empty: the generated scene
  double hz = 10;
  double seconds = 10;
  bool arr = false;  ///< the fields of all subscribers are recorded, not declared
  std::optional<std::filesystem::path> json{};

  std::uint64_t samples() const {
    return std::max<std::uint64_t>(1, static_cast<std::uint64_t>(hz * seconds + 0.5));
  }
};

}  // namespace sft::demo
