#include "from_msg/service.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <optional>
#include <string>
#include <utility>

#include "from_msg/lines.h"
#include "from_msg/names.h"
#include "from_msg/parse.h"
#include "from_msg/utf8.h"

namespace sft::msg {
namespace {

std::vector<Problem> problem(std::uint32_t line, std::string text) { return {{line, "", std::move(text)}}; }

/// Returns a text about the error in the name; empty if there is no error.
std::string fault_of(const TypeName& name) {
  if (!is_package_name(name.package)) {
    return fmt::format(
        "{} is not a package name: expected a lower-case letter, then lower-case letters, digits and "
        "single underscores, as in my_msgs",
        shown(name.package));
  }
  if (!is_message_name(name.name) || name.name.find('_') != name.name.npos) {
    return fmt::format(
        "{} is not a service name: expected a capital letter, then letters and digits, as in SetMode",
        shown(name.name));
  }
  return {};
}

/// One of the two parts of a .srv file.
struct Part {
  std::string_view text;
  std::uint32_t lines_before;
};

/// Cuts a text at the line "---", like ROS 2. There must be exactly one such line.
tl::expected<std::pair<Part, Part>, std::vector<Problem>> cut_in_two(std::string_view text) {
  std::optional<std::pair<Part, Part>> parts;
  std::uint32_t number = 1;
  for (std::size_t at = 0; at < text.size(); ++number) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    const std::size_t next = std::min(end + 1, text.size());
    if (text.substr(at, end - at) == "---") {
      if (parts) {
        return tl::unexpected(
            problem(number,
                    "a second line '---': a service has two parts; actions, which have three, are not "
                    "supported: use a service for goals, and topics for feedback and results"));
      }
      parts = {{text.substr(0, at), 0}, {text.substr(next), number}};
    }
    at = next;
  }
  if (parts) return *parts;
  const auto last = static_cast<std::uint32_t>(1 + std::ranges::count(text, '\n'));
  return tl::unexpected(problem(last, "there is no line '---' between the request and the response"));
}

Field field(sft_kind kind, const TypeName& nested, std::string_view name, std::uint32_t line) {
  Type type;
  type.kind = kind;
  type.nested = nested;
  return {type, std::string(name), {}, {}, line};
}

/// Returns the message that carries `part` between client and server. Its first fields are those of
/// sft/service.h.
Definition envelope(const Definition& part, std::string_view service, std::string_view suffix,
                    std::string_view member) {
  Definition carrier;
  carrier.type = {part.type.package, fmt::format("{}_{}", service, suffix), part.type.folder};
  const std::uint32_t line = part.fields.front().line;
  for (const char* name : {"client", "number", "server"})
    carrier.fields.push_back(field(SFT_UINT64, {}, name, line));
  const bool is_call = member == "request";
  carrier.fields.push_back(is_call ? field(SFT_UINT32, {}, "timeout_ms", line)
                                   : field(SFT_STRING, {}, "error", line));
  carrier.fields.push_back(field(SFT_STRUCTURE, part.type, member, line));
  return carrier;
}

}  // namespace

tl::expected<std::vector<Definition>, std::vector<Problem>> parse_service(std::string_view text,
                                                                          const TypeName& name) {
  if (std::string fault = fault_of(name); !fault.empty()) return tl::unexpected(problem(1, std::move(fault)));
  if (text.size() > Limits::bytes)
    return tl::unexpected(problem(1, fmt::format("a service has at most {} bytes: put parts into messages of "
                                                 "their own",
                                                 Limits::bytes)));
  const std::string plain = with_plain_spaces(text);
  const auto parts = cut_in_two(plain);
  if (!parts) return tl::unexpected(parts.error());
  const auto part = [&](const Part& from, const char* suffix) {
    return parse(from.text, {name.package, name.name + suffix, name.folder}, from.lines_before);
  };
  auto request = part(parts->first, "_Request");
  auto response = part(parts->second, "_Response");
  std::vector<Problem> problems;
  for (auto* result : {&request, &response}) {
    if (!*result) std::ranges::move(result->error(), std::back_inserter(problems));
  }
  if (problems.size() > Limits::problems) problems.erase(problems.begin() + Limits::problems, problems.end());
  if (!problems.empty()) return tl::unexpected(std::move(problems));
  return std::vector{*request, *response, envelope(*request, name.name, "Call", "request"),
                     envelope(*response, name.name, "Reply", "response")};
}

}  // namespace sft::msg
