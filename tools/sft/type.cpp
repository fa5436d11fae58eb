#include "tools/sft/type.h"

#include <nlohmann/json.hpp>

#include "tools/sft/msg_text.h"
#include "tools/terminal/units.h"

namespace sft::tool {

ExitCode run(const TypeOptions& options, const CommonOptions& common, Session& session) {
  const Result<FoundTopic> topic = session.find(options.topic);
  if (!topic) return give_up(topic.error());
  const TypeSupport& support = topic->type.support();
  const std::string name = ros_name(topic->type.name());
  Output& output = session.output();
  std::vector<std::string> fields;
  for (std::size_t leaf = 0; leaf < support.leaves(); ++leaf) fields.push_back(support.path(leaf));
  if (common.json) {
    output.document({{"topic", topic->name},
                     {"type", name},
                     {"hash", hex_text(topic->type.hash())},
                     {"msg", msg_text(topic->type.type())},
                     {"fields", fields}});
  } else if (options.name) {
    output.line(name);
  } else if (options.fields) {
    for (const std::string& field : fields) output.line(field);
  } else {
    output.line(output.colored("# " + name, Color::dim));
    output.write(msg_text(topic->type.type()));
  }
  return ExitCode::done;
}

}  // namespace sft::tool
