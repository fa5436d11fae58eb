// Messages from the standard input, one after the other.
#pragma once

#include <optional>
#include <string>

#include "tools/terminal/stop.h"

namespace sft::tool {

/// Reads documents as `sft echo` writes them: YAML with a line `---` between documents, or one JSON document
/// per line.
class Documents {
 public:
  explicit Documents(Stop& stop) : stop_(stop) {}

  /// Waits for the next complete document, and returns it; nothing at the end of the input, or if the user
  /// wants to stop.
  std::optional<std::string> next();

 private:
  std::optional<std::string> line();

  Stop& stop_;
  std::string read_;  ///< read from the input, but not returned yet
  bool is_over_ = false;
};

}  // namespace sft::tool
