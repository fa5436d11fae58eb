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
  std::vector<std::string> rules{};  ///< as parse_bridge_rule() takes them
  std::string file{};                ///< a file with sides and rules; the next five have no effect then
  std::optional<std::uint32_t> to{};
  std::vector<std::string> to_interfaces{}, to_peers{};
  std::string from_dds{}, to_dds{};       ///< as vanilla_choice_of() takes them; empty: $SFT_VANILLA_DDS
  BridgeRuleOptions each{};               ///< what holds for all of `rules`
  std::vector<std::string> priorities{};  ///< TOPIC=NUMBER
  double for_s = 0;                       ///< 0: until the user stops it
};

/// The domain, the interfaces and the peers of `common` are those of the first side.
ExitCode run(const BridgeOptions& options, const CommonOptions& common, Stop& stop, Output& output);

}  // namespace sft::tool
