// What commands print: on a terminal with colours and in its width, elsewhere plain and whole.
#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

#include "tools/sft/stop.h"

namespace sft::tool {

enum class Color : int { none = 0, red = 31, green = 32, yellow = 33, cyan = 36, bold = 1, dim = 2 };

class Output {
 public:
  /// Colours need a terminal, and that neither `no_color` nor the environment variable NO_COLOR rules them
  /// out.
  Output(Stop& stop, bool no_color);

  bool on_terminal() const { return terminal_; }
  std::size_t columns() const;
  std::size_t rows() const;
  std::string colored(std::string_view text, Color color) const;
  /// In lines that fit the terminal, as wrapped() makes them; elsewhere whole.
  std::string fitted(std::string_view text, std::size_t indent, std::size_t before = 0) const;

  /// At once. Where nobody reads it any more, the command is to stop.
  void write(std::string_view text);
  void line(std::string_view text);
  /// In one line, for programs that read line by line.
  void record(const nlohmann::ordered_json& json);
  /// Indented, for people who look at it as well.
  void document(const nlohmann::ordered_json& json);

 private:
  Stop& stop_;
  bool terminal_;
  bool colors_;
};

/// One sentence on the standard error.
void complain(std::string_view sentence);

/// Other nodes' words on a terminal: without what could steer it. Names that were announced have no such
/// characters, reasons and types may quote what somebody else wrote.
std::string printable(std::string_view text);

}  // namespace sft::tool
