// Reads messages from the standard input, one after the other.
#pragma once

#include <optional>
#include <string>

#include "tools/terminal/stop.h"

namespace sft::tool {

/// Reads documents in the format of `sft echo`: YAML with a line `---` between documents, or one JSON
/// document per line.
class Documents {
 public:
  explicit Documents(Stop& stop) : stop_(stop) {}

  /// Waits for the next complete document, and returns it. Returns nothing at the end of the input, or if the
  /// user wants to stop.
  std::optional<std::string> next();

 private:
  std::optional<std::string> line();

  Stop& stop_;
  std::string read_;  ///< the text that was read from the input, but not returned yet
  bool is_over_ = false;
};

}  // namespace sft::tool
