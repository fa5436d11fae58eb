// The output of commands: text, on a terminal or elsewhere, and JSON.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

#include "tools/terminal/stop.h"
#include "tools/terminal/terminal.h"

namespace sft::tool {

class Output : public Terminal {
 public:
  Output(Stop& stop, bool no_color);

  /// Writes the text at once. If the write fails, the command is asked to stop.
  void write(std::string_view text);
  /// Returns the reason why the output could not be written. Returns an empty text if all of it was written.
  /// The text is also empty if the reader has closed the output, which is a regular end.
  const std::string& failure() const { return failure_; }
  void line(std::string_view text);
  /// Writes JSON in one line, for programs that read line by line.
  void record(const nlohmann::ordered_json& json);
  /// Writes JSON with indentation, which is easier to read for people.
  void document(const nlohmann::ordered_json& json);

 private:
  Stop& stop_;
  std::string failure_;
};

/// Writes one sentence to the standard error.
void complain(std::string_view sentence);

/// Returns a text of other nodes without characters that would control the terminal. Announced names have no
/// such characters, but reasons and types may quote any text.
std::string printable(std::string_view text);

}  // namespace sft::tool
