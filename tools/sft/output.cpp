#include "tools/sft/output.h"

#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <system_error>

namespace sft::tool {

namespace {

using Json = nlohmann::ordered_json;

std::string dumped(const Json& json, int indent) {
  return json.dump(indent, ' ', false, Json::error_handler_t::replace) + '\n';
}

std::string text_of(int error) { return std::generic_category().message(error); }

}  // namespace

Output::Output(Stop& stop, bool no_color) : Terminal(no_color), stop_(stop) {}

void Output::write(std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = ::write(STDOUT_FILENO, text.data(), text.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) {
      if (errno != EPIPE) failure_ = text_of(errno);
      return stop_.request();
    }
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
