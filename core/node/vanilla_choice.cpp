#include "core/node/vanilla_choice.h"

#include <string>
#include <string_view>

#include "core/platform/quotes.h"

namespace sft::core {

Result<NodeOptions::VanillaDds> vanilla_choice(std::optional<NodeOptions::VanillaDds> program,
                                               const char* environment) {
  using enum NodeOptions::VanillaDds;
  if (program) return *program;
  const std::string_view text = environment == nullptr ? "" : environment;
  if (text.empty() || text == "auto") return automatic;
  if (text == "always") return always;
  if (text == "never") return never;
  return fail(Errc::invalid_argument, "the environment variable SFT_VANILLA_DDS is " +
                                          in_quotes(std::string(text)) +
                                          ", which is none of auto, always, never");
}

Result<NodeOptions::DdsNames> dds_names_choice(std::optional<NodeOptions::DdsNames> program,
                                               const char* environment) {
  using enum NodeOptions::DdsNames;
  if (program) return *program;
  const std::string_view text = environment == nullptr ? "" : environment;
  if (text.empty() || text == "ros2") return ros2;
  if (text == "plain") return plain;
  return fail(Errc::invalid_argument, "the environment variable SFT_DDS_NAMES is " +
                                          in_quotes(std::string(text)) + ", which is neither ros2 nor plain");
}

}  // namespace sft::core
