// The standard output of commands: with colours and in the width of a terminal, elsewhere plain and in full.
#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

#include "tools/terminal/stop.h"

namespace sft::tool {

enum class Color : int { none = 0, red = 31, green = 32, yellow = 33, cyan = 36, bold = 1, dim = 2 };

class Output {
 public:
  /// Uses colours on a terminal, unless `no_color` or the environment variable NO_COLOR rules them out.
  Output(Stop& stop, bool no_color);

  bool on_terminal() const { return terminal_; }
  std::size_t columns() const;
  std::size_t rows() const;
  std::string colored(std::string_view text, Color color) const;
  /// Breaks the text into lines that fit the terminal, as wrapped() does. Returns it unchanged without a
  /// terminal.
  std::string fitted(std::string_view text, std::size_t indent, std::size_t before = 0) const;

  /// Writes without a buffer. Asks the command to stop if the reader of the output has gone.
  void write(std::string_view text);
  void line(std::string_view text);
  /// Writes JSON in one line, for programs that read line by line.
  void record(const nlohmann::ordered_json& json);
  /// Writes indented JSON, for people and programs.
  void document(const nlohmann::ordered_json& json);

 private:
  Stop& stop_;
  bool terminal_;
  bool colors_;
};

/// Writes one sentence to the standard error.
void complain(std::string_view sentence);

/// Replaces control characters, so that text of other nodes cannot steer the terminal. Announced names have
/// no control characters, but reasons and types may quote what another program wrote.
std::string printable(std::string_view text);

}  // namespace sft::tool
