#include "tools/sft/screen.h"

#include <algorithm>

#include "tools/terminal/columns.h"

namespace sft::tool {

Screen::Screen(Output& output) : output_(output) {
  output_.write("\x1b[?1049h\x1b[?25l");  // the alternative screen, without a cursor
}

Screen::~Screen() { output_.write("\x1b[?25h\x1b[?1049l"); }

void Screen::show(const std::vector<Line>& lines) {
  std::string page = "\x1b[H";
  const std::size_t rows = std::min(lines.size(), output_.rows());
  for (std::size_t i = 0; i < rows; ++i) {
    page += output_.colored(std::string(cut(lines[i].text, output_.columns())), lines[i].color) + "\x1b[K";
    if (i + 1 < rows) page += "\r\n";
  }
  output_.write(page + "\x1b[J");
}

}  // namespace sft::tool
