// Messages that come by the standard input, one after the other.
#pragma once

#include <optional>
#include <string>

#include "tools/sft/stop.h"

namespace sft::tool {

/// Documents as `sft echo` writes them: YAML, each with a line `---` behind it (or in front), or JSON, each
/// in a line of its own.
class Documents {
 public:
  explicit Documents(Stop& stop) : stop_(stop) {}

  /// The next one, as soon as it is complete. Nothing at the end, or when the user wants to stop.
  std::optional<std::string> next();

 private:
  std::optional<std::string> line();

  Stop& stop_;
  std::string read_;  ///< and not yet given out
  bool is_over_ = false;
};

}  // namespace sft::tool
