// `sft bridge`: carries topics from one domain to another, by rules.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "tools/sft/bridge_rules.h"
#include "tools/sft/common_options.h"
#include "tools/sft/exit_code.h"
#include "tools/sft/output.h"

namespace sft::tool {

struct BridgeOptions {
  std::vector<std::string> rules{};  ///< rules in the form of parse_bridge_rule()
  std::string file{};  ///< a file with sides and rules; if it is given, the next five members are ignored
  std::optional<std::uint32_t> to{};
  std::vector<std::string> to_interfaces{}, to_peers{};
  std::string from_dds{}, to_dds{};       ///< texts for vanilla_choice_of(); empty: $SFT_VANILLA_DDS
  BridgeRuleOptions each{};               ///< options that hold for all of `rules`
  std::vector<std::string> priorities{};  ///< texts of the form TOPIC=NUMBER
  double for_s = 0;                       ///< the duration in seconds; 0: until the user stops the command
};

/// Runs the command. `common` has the domain, the interfaces and the peers of the first side.
ExitCode run(const BridgeOptions& options, const CommonOptions& common, Stop& stop, Output& output);

}  // namespace sft::tool
