#include "tools/sft/output.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "tools/terminal/wrapped.h"

namespace sft::tool {

namespace {

using Json = nlohmann::ordered_json;

std::string dumped(const Json& json, int indent) {
  return json.dump(indent, ' ', false, Json::error_handler_t::replace) + '\n';
}

winsize terminal_size() {
  winsize size{};
  ioctl(STDOUT_FILENO, TIOCGWINSZ, &size);
  return size;
}

}  // namespace

Output::Output(Stop& stop, bool no_color) : stop_(stop), terminal_(isatty(STDOUT_FILENO) != 0) {
  const char* unwanted = std::getenv("NO_COLOR");
  colors_ = terminal_ && !no_color && (unwanted == nullptr || *unwanted == '\0');
}

std::size_t Output::columns() const {
  const std::size_t columns = terminal_ ? terminal_size().ws_col : 0;
  return columns == 0 ? 80 : columns;
}

std::size_t Output::rows() const {
  const std::size_t rows = terminal_ ? terminal_size().ws_row : 0;
  return rows == 0 ? 24 : rows;
}

std::string Output::colored(std::string_view text, Color color) const {
  if (!colors_ || color == Color::none) return std::string(text);
  return "\x1b[" + std::to_string(static_cast<int>(color)) + "m" + std::string(text) + "\x1b[0m";
}

std::string Output::fitted(std::string_view text, std::size_t indent, std::size_t before) const {
  return terminal_ ? wrapped(text, columns(), indent, before) : std::string(text);
}

void Output::write(std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = ::write(STDOUT_FILENO, text.data(), text.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return stop_.request();
    text.remove_prefix(static_cast<std::size_t>(written));
  }
}

void Output::line(std::string_view text) { write(std::string(text) + '\n'); }

void Output::record(const Json& json) { write(dumped(json, -1)); }

void Output::document(const Json& json) { write(dumped(json, 2)); }

void complain(std::string_view sentence) { std::fprintf(stderr, "sft: %s\n", printable(sentence).c_str()); }

std::string printable(std::string_view text) {
  std::string clean;
  for (const char c : text) clean += static_cast<unsigned char>(c) < 0x20 || c == 0x7f ? ' ' : c;
  return clean;
}

}  // namespace sft::tool
