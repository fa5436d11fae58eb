// Resolves the names of a node and of its topics as ROS 2 does: with the namespace, relative and private
// names, and remapping rules. Uses no clock, thread or I/O.
//
//   node 'cam' in the namespace 'left'       rules: '~/image:=raw'  '/left/cam:info:=a'
//   the program says   '~/image'             'info'          'points'        '/clock'
//   in full            'left/cam/image'      'left/info'     'left/points'   'clock'
//   the topic          'left/raw'            'left/a'        'left/points'   'clock'
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "sft/options.h"
#include "sft/result.h"

namespace sft::core {

/// A topic: the name that the program of a node uses, and the name that other nodes see.
struct TopicName {
  std::string topic;  ///< the resolved name, without a leading slash
  /// The name that the program uses. Empty if it equals `topic`, apart from a leading slash.
  std::string given{};
  /// All rules that match the name, as they were written. Only the first of them was applied.
  std::vector<std::string> rules{};
  /// Returns the error with the name that the program uses added to its text.
  Error explained(Error error) const;
};

class Remapping {
 public:
  /// Makes an object without a namespace and rules, for a node without a name.
  Remapping() = default;
  /// Makes the remapping of a node from its options. `environment` is the value of SFT_REMAP, or null; its
  /// rules come before those of the options. The error says what is wrong with a rule, the name of the node
  /// or its namespace.
  static Result<Remapping> of(const NodeOptions& options, const char* environment);

  /// Returns the full name of the node: "left/cam". The result is empty if the node has no name.
  std::string node() const;
  /// Resolves a topic that the program names. Returns Errc::invalid_argument if the name is invalid. A rule
  /// for the name of a service applies to both of its topics, which are recognized by their types
  /// (sft/service.h). `type` may be empty.
  Result<TopicName> topic(std::string_view given, std::string_view type = {}) const;

  /// Returns all rules as they were written, including those for other nodes.
  const std::vector<std::string>& rules() const { return texts_; }
  /// Returns the rules about node names and namespaces that match this node.
  const std::vector<std::string>& rules_of_node() const { return rules_of_node_; }

 private:
  /// A rule for topics of this node. `from` and `to` are full names.
  struct TopicRule {
    std::string text, from, to;
  };
  struct Rule;
  static Result<Rule> parse(std::string_view text, const std::string& source);
  static Result<std::vector<Rule>> parse_all(const NodeOptions& options, const char* environment);
  bool is_for_node(const Rule& rule) const;
  void name_node(const std::vector<Rule>& rules);
  Result<void> add_topic_rule(const Rule& rule);
  Result<std::string> full(std::string_view given) const;

  std::string name_, namespace_;  ///< the node's name, and its namespace without a slash at either end
  std::vector<TopicRule> topic_rules_;
  std::vector<std::string> texts_, rules_of_node_;
};

}  // namespace sft::core
