// The text of a header. The emitters append lines to it.
#pragma once

#include <fmt/format.h>

#include <iterator>
#include <string>
#include <string_view>
#include <utility>

namespace sft::idl {

class Code {
 public:
  /// Appends one formatted line.
  template <class... Args>
  void line(fmt::format_string<Args...> format, Args&&... args) {
    fmt::format_to(std::back_inserter(text_), format, std::forward<Args>(args)...);
    text_ += '\n';
  }
  void blank() { text_ += '\n'; }
  void append(std::string_view lines) { text_ += lines; }

  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

}  // namespace sft::idl
