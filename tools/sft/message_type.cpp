#include "tools/sft/message_type.h"

#include <algorithm>
#include <optional>

#include "tools/sft/definitions.h"
#include "tools/sft/msg_text.h"

namespace sft::tool {

namespace {

/// Converts any form of a type's name to the short form: "sensor_msgs/PointCloud2".
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

Result<DynamicType> find_message_type(const std::string& type, const std::string& topic, Session& session) {
  if (type == "auto") return session.find(topic).map([](const FoundTopic& found) { return found.type; });
  const Result<DynamicType> defined = find_definition(type, session.options());
  if (type.ends_with(".msg")) return defined;
  const bool is_elsewhere = !defined && (defined.error().code == Errc::unavailable ||
                                         defined.error().code == Errc::invalid_argument);
  if (!is_elsewhere) return defined;
  std::optional<DynamicType> found;
  session.wait_until([&](const DomainSnapshot& domain) {
    found = announced(short_name(type), domain);
    return found.has_value();
  });
  if (found) return *found;
  return fail(defined.error().code, defined.error().message +
                                        "; and no node announces such a type in domain " +
                                        std::to_string(session.node().status().domain));
}

}  // namespace sft::tool
