#include "tools/sft/type.h"

#include <cctype>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "tools/sft/definitions.h"
#include "tools/sft/message_type.h"
#include "tools/sft/msg_text.h"
#include "tools/terminal/units.h"

namespace sft::tool {

namespace {

using Json = nlohmann::ordered_json;

struct Subject {
  DynamicType type;
  std::optional<std::string> topic{};  ///< the topic whose type was found; empty: the type was found by its
                                       ///< own name
};

/// Prints a service as the text of its file.
ExitCode print_service(const std::string& text, const TypeOptions& options, const CommonOptions& common,
                       Output& output) {
  if (options.fields) {
    complain("'" + printable(options.topic) + "' is a service, and --fields is for messages: leave it out");
    return ExitCode::failed;
  }
  if (common.json) {
    output.document({{"topic", Json()}, {"type", options.topic}, {"srv", text}});
  } else if (options.name) {
    output.line(options.topic);
  } else {
    output.write(text);
  }
  return ExitCode::done;
}

/// Returns true if a type may have this name: "sensor_msgs/PointCloud2", the same with "msg" between both
/// words, or the name of a file. A topic may have such a name, too.
bool may_be_type(std::string_view name) {
  const std::string short_form = msg_name(name);
  const std::size_t slash = short_form.rfind('/');
  return slash != short_form.npos && slash > 0 && slash + 1 < short_form.size() &&
         std::isupper(static_cast<unsigned char>(short_form[slash + 1])) != 0;
}

Result<Subject> find_topic(const TypeOptions& options, Session& session) {
  return session.find(options.topic).map([](const FoundTopic& found) {
    return Subject{found.type, found.name};
  });
}

/// Returns the text of the service with that name, or nothing. A message of the same name takes precedence.
std::optional<std::string> service_of(const TypeOptions& options, const CommonOptions& common,
                                      Session& session) {
  const std::optional<std::string> text = find_service(options.topic, common);
  if (!text || Session::known_name(options.topic, session.look_around())) return {};
  return find_definition(options.topic, common) ? std::nullopt : text;
}

Result<Subject> find(const TypeOptions& options, Session& session) {
  if (!may_be_type(options.topic) || Session::known_name(options.topic, session.look_around()))
    return find_topic(options, session);
  const auto type = find_message_type(options.topic, options.topic, session);
  if (type) return Subject{*type};
  const Result<DynamicType> topic = session.node().find_type(options.topic, std::chrono::nanoseconds(0));
  if (topic) return Subject{*topic, Session::plain_name(options.topic)};
  return fail(type.error().code, topic.error().message + "; as a type: " + type.error().message);
}

}  // namespace

ExitCode run(const TypeOptions& options, const CommonOptions& common, Session& session) {
  if (const auto service = service_of(options, common, session))
    return print_service(*service, options, common, session.output());
  const Result<Subject> subject = find(options, session);
  if (!subject) return give_up(subject.error());
  const DynamicType& type = subject->type;
  const TypeSupport& support = type.support();
  const std::string name = ros_name(type.name());
  Output& output = session.output();
  const auto constants = [&](const StructType& one) { return constants_of(one, common); };
  std::vector<std::string> fields;
  for (std::size_t leaf = 0; leaf < support.leaves(); ++leaf) fields.push_back(support.path(leaf));
  if (common.json) {
    output.document({{"topic", subject->topic ? Json(*subject->topic) : Json()},
                     {"type", name},
                     {"hash", hex_text(type.hash())},
                     {"msg", msg_text(type.type(), constants)},
                     {"fields", fields}});
  } else if (options.name) {
    output.line(name);
  } else if (options.fields) {
    for (const std::string& field : fields) output.line(field);
  } else {
    output.line(output.colored("# " + name, Color::dim));
    output.write(msg_text(type.type(), constants));
  }
  return ExitCode::done;
}

}  // namespace sft::tool
