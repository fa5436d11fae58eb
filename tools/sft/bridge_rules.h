// The rules of `sft bridge`, and the two sides that it joins.
//
//   points{data{x,y,z}}[::4] -> robot/points    from the first side to the second, under another name
//   cmd_vel <- robot/cmd_vel                    from the second side to the first
//   chatter <-> chatter                         both ways
//   tf                                          to the second side, under the same name
//   camera/* -> robot/camera/*                  all topics whose names match
#pragma once

#include <sft/options.h>
#include <sft/result.h>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace sft::tool {

/// The greatest and, with a minus, the smallest priority of a rule.
inline constexpr std::int8_t bridge_priority_most = 100;

/// The options of a rule, without its topic and its direction.
struct BridgeRuleOptions {
  /// Fields that are zero or empty on the other side if they are not selected; "*": all
  std::vector<std::string> defaults{};
  std::int8_t priority = 0;  ///< the value of PublisherOptions::priority
  bool reliable = false;     ///< true: offers reliability even if the original publisher does not
};

/// One direction of a rule.
struct BridgeRule {
  std::string text{};       ///< the rule as the user has written it
  std::size_t from = 0;     ///< the index of the side from which samples are taken: 0 or 1
  std::string topic{};      ///< the name of the topic on that side, without a leading slash; may have one "*"
  std::string selection{};  ///< the selection in the form of selection_of(); empty: all fields
  std::string target{};     ///< the name on the other side; has a "*" if `topic` has one
  BridgeRuleOptions options{};

  std::size_t to() const { return 1 - from; }
  bool is_pattern() const { return topic.find('*') != topic.npos; }
  /// Returns the name on the other side of the topic `name`; nothing if the rule does not apply to this
  /// topic.
  std::optional<std::string> target_of(std::string_view name) const;
};

struct BridgeSide {
  std::string name{};  ///< the name of the side for messages; empty: "domain N"
  NodeOptions node{};
};

struct BridgePlan {
  std::array<BridgeSide, 2> sides{};
  std::vector<BridgeRule> rules{};
};

/// Returns the directions of a rule, one or two. The error shows the text and says what is wrong with it.
Result<std::vector<BridgeRule>> parse_bridge_rule(const std::string& text, const BridgeRuleOptions& options);

/// Reads a file of `sft bridge` (docs/bridge.md) into `plan`. The error names file, line, key and value.
Result<void> read_bridge_file(const std::string& path, BridgePlan& plan);

/// Returns an error if two rules carry the same topic to the same target.
Result<void> check_rules(const std::vector<BridgeRule>& rules);

/// Reads "auto", "always" or "never".
std::optional<NodeOptions::VanillaDds> vanilla_choice_of(std::string_view word);

}  // namespace sft::tool
