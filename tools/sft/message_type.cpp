#include "tools/sft/message_type.h"

#include <algorithm>
#include <filesystem>
#include <optional>

#include "tools/sft/msg_text.h"

namespace sft::tool {

namespace {

namespace fs = std::filesystem;

/// The messages of SFT, at a path relative to the program, wherever that is installed. The build tree has a
/// link there.
fs::path own_interfaces() {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  return (program.parent_path() / SFT_INTERFACES_FROM_PROGRAM).lexically_normal();
}

/// Maps all forms of a type's name to one: "sensor_msgs/PointCloud2".
std::string short_name(std::string_view name) {
  std::string text = msg_name(name);
  if (const std::size_t at = text.find("/msg/"); at != text.npos) text.erase(at, 4);
  return text;
}

std::optional<DynamicType> announced(const std::string& name, const DomainSnapshot& domain) {
  for (const auto* endpoints : {&domain.publishers, &domain.subscribers}) {
    const auto found = std::ranges::find_if(*endpoints, [&](const DomainSnapshot::Endpoint& e) {
      return e.type.has_value() && short_name(e.type_name) == name;
    });
    if (found != endpoints->end()) return found->type;
  }
  return {};
}

}  // namespace

Result<DynamicType> find_message_type(const TypeChoice& choice, const std::string& topic, Session& session) {
  if (choice.type == "auto")
    return session.find(topic).map([](const FoundTopic& found) { return found.type; });
  std::vector<fs::path> roots(choice.includes.begin(), choice.includes.end());
  roots.push_back(own_interfaces());
  if (choice.type.ends_with(".msg")) return from_msg_file(choice.type, roots);
  const Result<DynamicType> defined = find_msg(choice.type, roots);
  const bool is_elsewhere = !defined && (defined.error().code == Errc::unavailable ||
                                         defined.error().code == Errc::invalid_argument);
  if (!is_elsewhere) return defined;
  std::optional<DynamicType> found;
  session.wait_until([&](const DomainSnapshot& domain) {
    found = announced(short_name(choice.type), domain);
    return found.has_value();
  });
  if (found) return *found;
  return fail(defined.error().code, defined.error().message +
                                        "; and no node announces such a type in domain " +
                                        std::to_string(session.node().status().domain));
}

}  // namespace sft::tool
