#include "tools/sft/documents.h"

#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <nlohmann/json.hpp>

namespace sft::tool {

namespace {

bool is_blank(const std::string& text) { return text.find_first_not_of(" \t\r\n") == text.npos; }

bool is_separator(const std::string& line) { return line.starts_with("---") && is_blank(line.substr(3)); }

}  // namespace

std::optional<std::string> Documents::next() {
  std::string document;
  while (const auto next = line()) {
    if (is_separator(*next)) {
      if (!is_blank(document)) return document;
      document.clear();
    } else if (is_blank(document) && next->starts_with('{') && nlohmann::json::accept(*next)) {
      return next;
    } else {
      document += *next;
    }
  }
  if (is_blank(document) || stop_.requested()) return {};
  return document;
}

/// Returns the next line with its line break. The last line of the input may lack the line break.
std::optional<std::string> Documents::line() {
  std::size_t searched = 0;
  for (;;) {
    const std::size_t end = read_.find('\n', searched);
    if (end != read_.npos || (is_over_ && !read_.empty())) {
      std::string line = read_.substr(0, end == read_.npos ? end : end + 1);
      read_.erase(0, line.size());
      return line;
    }
    if (is_over_) return {};
    searched = read_.size();
    if (stop_.wait_for(std::chrono::hours(1), STDIN_FILENO)) return {};
    std::array<char, 65536> part;
    const ssize_t bytes = read(STDIN_FILENO, part.data(), part.size());
    if (bytes > 0) read_.append(part.data(), static_cast<std::size_t>(bytes));
    is_over_ = bytes == 0 || (bytes < 0 && errno != EINTR && errno != EAGAIN);
  }
}

}  // namespace sft::tool
