#include "core/names/remapping.h"

#include <algorithm>
#include <cstdint>
#include <utility>

#include "core/names/names.h"

namespace sft::core {

namespace {

constexpr std::string_view blanks = " \t\r\n";
constexpr std::string_view forms =
    "; a rule is FROM:=TO, NODE:FROM:=TO, __node:=NAME or __ns:=/NAMESPACE, as 'ros2 run ... -r' takes it";

/// Does the same as fault_of_topic(), but allows private names.
std::string_view fault_of_given(std::string_view name) {
  if (name == "~") return {};
  return fault_of_topic(name.starts_with("~/") ? name.substr(1) : name);
}

std::string joined(std::string_view space, std::string_view name) {
  return space.empty() ? std::string(name) : std::string(space) + '/' + std::string(name);
}

/// Returns the part of a service's topic that follows the name of the service: "/call" or "/reply". The
/// result is empty for other topics.
std::string_view end_of_service(std::string_view topic, std::string_view type) {
  if (type.find("::srv::") == type.npos) return {};
  if (type.ends_with("_Call") && topic.ends_with("/call")) return "/call";
  return type.ends_with("_Reply") && topic.ends_with("/reply") ? "/reply" : "";
}

}  // namespace

Error TopicName::explained(Error error) const {
  if (!given.empty()) error.message += " (the program calls this topic " + in_quotes(given) + ")";
  return error;
}

struct Remapping::Rule {
  enum class About : std::uint8_t { topic, node_name, node_namespace };
  std::string text;    ///< the rule as it was written
  std::string source;  ///< the place where the rule was written, for errors
  std::string node{};  ///< the node that the rule is for; empty: all nodes
  About about = About::topic;
  std::string from{};  ///< the topic name to replace, for rules about topics
  std::string to{};

  tl::unexpected<Error> refused(const std::string& why) const {
    return fail(Errc::invalid_argument,
                in_quotes(text) + " in " + source + " is no remapping rule: " + why + std::string(forms));
  }
  Result<void> check() const {
    const std::string_view fault = about == About::topic       ? fault_of_given(to)
                                   : about == About::node_name ? fault_of_node(to)
                                   : to.empty()                ? "is empty"
                                                               : fault_of_namespace(to);
    if (!fault.empty()) return refused("what stands behind ':=' " + std::string(fault));
    const std::string_view of_from = about == About::topic ? fault_of_given(from) : std::string_view();
    if (!of_from.empty()) return refused("the topic before ':=' " + std::string(of_from));
    return {};
  }
};

Result<Remapping::Rule> Remapping::parse(std::string_view text, const std::string& source) {
  Rule rule{.text = std::string(text), .source = source};
  const std::size_t middle = text.find(":=");
  if (middle == text.npos) return rule.refused("it has no ':='");
  std::string_view from = text.substr(0, middle);
  const std::string_view to = text.substr(middle + 2);
  if (to.find(":=") != to.npos) return rule.refused("it has a second ':='");
  if (const std::size_t colon = from.rfind(':'); colon != from.npos) {
    rule.node = from.substr(0, colon);
    from.remove_prefix(colon + 1);
    if (const auto fault = fault_of_topic(rule.node); !fault.empty())
      return rule.refused("the name of the node " + std::string(fault));
  }
  if (from == "__node" || from == "__name") rule.about = Rule::About::node_name;
  if (from == "__ns") rule.about = Rule::About::node_namespace;
  if (rule.about == Rule::About::topic && from.starts_with("__"))
    return rule.refused("there is no " + in_quotes(from));
  rule.from = from;
  rule.to = to;
  if (const Result<void> sound = rule.check(); !sound) return tl::unexpected(sound.error());
  return rule;
}

Result<std::vector<Remapping::Rule>> Remapping::parse_all(const NodeOptions& options,
                                                          const char* environment) {
  std::vector<std::pair<std::string_view, std::string>> texts;
  std::string_view left = environment == nullptr ? "" : environment;
  for (;;) {
    left.remove_prefix(std::min(left.find_first_not_of(blanks), left.size()));
    if (left.empty()) break;
    const std::string_view text = left.substr(0, left.find_first_of(blanks));
    texts.emplace_back(text, "the environment variable SFT_REMAP");
    left.remove_prefix(text.size());
  }
  for (const std::string& text : options.remap) texts.emplace_back(text, "NodeOptions::remap");
  std::vector<Rule> rules;
  for (const auto& [text, source] : texts) {
    Result<Rule> rule = parse(text, source);
    if (!rule) return tl::unexpected(rule.error());
    rules.push_back(std::move(*rule));
  }
  return rules;
}

Result<Remapping> Remapping::of(const NodeOptions& options, const char* environment) {
  if (const auto fault = fault_of_namespace(options.namespace_); !fault.empty()) {
    return fail(Errc::invalid_argument,
                "NodeOptions::namespace_ " + in_quotes(options.namespace_) + " " + std::string(fault));
  }
  const Result<std::vector<Rule>> rules = parse_all(options, environment);
  if (!rules) return tl::unexpected(rules.error());
  Remapping made;
  made.name_ = options.name;
  made.namespace_ = without_slash(options.namespace_);
  made.name_node(*rules);
  if (const auto fault = fault_of_node(made.name_); !fault.empty())
    return fail(Errc::invalid_argument,
                "the node's name " + in_quotes(made.name_) + " " + std::string(fault));
  for (const Rule& rule : *rules) {
    made.texts_.push_back(rule.text);
    if (const Result<void> added = made.add_topic_rule(rule); !added) return tl::unexpected(added.error());
  }
  return made;
}

/// Returns true if the rule is for this node. A rule's node without a slash, such as `cam`, means any node
/// with that name. A text with a slash is the full name of a node.
bool Remapping::is_for_node(const Rule& rule) const {
  return rule.node.empty() || rule.node == name_ || without_slash(rule.node) == node();
}

/// Applies the rules for the node's name and namespace.
void Remapping::name_node(const std::vector<Rule>& rules) {
  const Rule* name = nullptr;
  const Rule* space = nullptr;
  for (const Rule& rule : rules) {
    if (rule.about == Rule::About::topic || !is_for_node(rule)) continue;
    const Rule*& first = rule.about == Rule::About::node_name ? name : space;
    if (first == nullptr) first = &rule;
    rules_of_node_.push_back(rule.text);
  }
  if (name != nullptr) name_ = name->to;
  if (space != nullptr) namespace_ = without_slash(space->to);
}

Result<void> Remapping::add_topic_rule(const Rule& rule) {
  if (rule.about != Rule::About::topic || !is_for_node(rule)) return {};
  const Result<std::string> from = full(rule.from), to = full(rule.to);
  for (const Result<std::string>* name : {&from, &to}) {
    if (!*name) return rule.refused(name->error().message);
  }
  topic_rules_.push_back({rule.text, *from, *to});
  return {};
}

std::string Remapping::node() const { return name_.empty() ? name_ : joined(namespace_, name_); }

/// Returns the full name of the topic, without a leading slash. `given` must be valid.
Result<std::string> Remapping::full(std::string_view given) const {
  const std::string whole = given.starts_with('~')   ? node() + std::string(given.substr(1))
                            : given.starts_with('/') ? std::string(given.substr(1))
                                                     : joined(namespace_, given);
  if (given.starts_with('~') && name_.empty())
    return fail(Errc::invalid_argument, "topic " + in_quotes(given) + " is in a node that has no name");
  const std::string_view fault = fault_of_topic(whole);
  if (fault.empty()) return whole;
  return fail(Errc::invalid_argument, "topic " + in_quotes(given) + ", which is " + in_quotes(whole) +
                                          " here, " + std::string(fault));
}

Result<TopicName> Remapping::topic(std::string_view given, std::string_view type) const {
  if (const auto fault = fault_of_given(given); !fault.empty())
    return fail(Errc::invalid_argument, "topic " + in_quotes(given) + " " + std::string(fault));
  Result<std::string> whole = full(given);
  if (!whole) return tl::unexpected(whole.error());
  const std::string_view end = end_of_service(*whole, type);
  const std::string service = whole->substr(0, whole->size() - end.size());
  TopicName name{.topic = *whole};
  for (const TopicRule& rule : topic_rules_) {
    const bool is_whole = rule.from == *whole;
    if (!is_whole && rule.from != service) continue;
    if (name.rules.empty()) name.topic = is_whole ? rule.to : rule.to + std::string(end);
    name.rules.push_back(rule.text);
  }
  if (const auto fault = fault_of_topic(name.topic); !fault.empty())
    return fail(Errc::invalid_argument, "topic " + in_quotes(given) + ", which the rule " +
                                            in_quotes(name.rules.front()) + " renames, " +
                                            std::string(fault));
  if (name.topic != without_slash(given)) name.given = given;
  return name;
}

}  // namespace sft::core
