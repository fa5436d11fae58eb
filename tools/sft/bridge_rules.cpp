#include "tools/sft/bridge_rules.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <toml++/toml.h>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <regex>

#include "core/platform/text_file.h"
#include "tools/sft/session.h"
#include "tools/sft/topic_selection.h"

namespace sft::tool {

namespace {

constexpr double bytes_of_mbit = 125'000;

/// The first mistake in the file. Further mistakes are not reported.
class Mistake {
 public:
  explicit Mistake(std::string path) : path_(std::move(path)) {}
  void note(const toml::node& where, std::string_view what) {
    if (text_.empty()) text_ = fmt::format("{}:{}: {}", path_, where.source().begin.line, what);
  }
  const std::string& text() const { return text_; }

 private:
  std::string path_, text_;
};

/// Reads the keys of a table. The destructor reports the first key that was not read.
class TableReader {
 public:
  TableReader(const toml::table& table, Mistake& mistake) : table_(table), mistake_(mistake) {}
  ~TableReader() {
    for (const auto& [key, node] : table_) {
      if (std::ranges::find(known_, key.str()) == known_.end())
        mistake_.note(node,
                      fmt::format("'{}' is no key here; there are {}", key.str(), fmt::join(known_, ", ")));
    }
  }
  TableReader(const TableReader&) = delete;
  TableReader& operator=(const TableReader&) = delete;

  template <class Value>
  void read(std::string_view key, const char* example, Value& value) {
    known_.push_back(key);
    const toml::node* const node = table_.get(key);
    if (node == nullptr) return;
    const auto found = node->value<Value>();
    if (found)
      value = *found;
    else
      wrong(*node, key, example);
  }
  void read(std::string_view key, const char* example, std::vector<std::string>& values) {
    known_.push_back(key);
    const toml::node* const node = table_.get(key);
    if (node == nullptr) return;
    const toml::array* const array = node->as_array();
    if (array == nullptr) return wrong(*node, key, example);
    for (const toml::node& one : *array) {
      if (!one.is_string()) return wrong(one, key, example);
      values.push_back(one.value_or(std::string()));
    }
  }
  void wrong(const toml::node& node, std::string_view key, std::string_view example) {
    mistake_.note(node, fmt::format("'{}' has no such value: write for example {} = {}", key, key, example));
  }
  void wrong(std::string_view key, std::string_view example) {
    const toml::node* const node = table_.get(key);
    wrong(node == nullptr ? table_ : *node, key, example);
  }

 private:
  const toml::table& table_;
  Mistake& mistake_;
  std::vector<std::string_view> known_{};
};

void read_side(const toml::table& table, Mistake& mistake, BridgeSide& side) {
  TableReader keys(table, mistake);
  std::int64_t domain = -1;
  std::string dds, cyclonedds;
  double limit_mbit = 0;
  keys.read("name", "\"robot\"", side.name);
  keys.read("domain", "0", domain);
  keys.read("dds", "\"auto\"", dds);
  keys.read("interfaces", "[\"eth0\"]", side.node.discovery.interfaces);
  keys.read("peers", "[\"10.0.0.7\"]", side.node.discovery.peers);
  keys.read("cyclonedds", "\"file:///etc/cyclonedds.xml\"", cyclonedds);
  keys.read("limit_mbit", "20.0", limit_mbit);
  const bool has_domain = table.contains("domain");
  if (has_domain && (domain < 0 || domain > static_cast<std::int64_t>(NodeOptions::domain_max)))
    keys.wrong("domain", "0");
  if (domain >= 0) side.node.domain = static_cast<std::uint32_t>(domain);
  side.node.vanilla_dds = vanilla_choice_of(dds);
  if (!dds.empty() && !side.node.vanilla_dds) keys.wrong("dds", "\"auto\", or \"always\" or \"never\"");
  if (!cyclonedds.empty()) side.node.cyclonedds_config = cyclonedds;
  if (!(limit_mbit >= 0 && limit_mbit < 1e6)) return keys.wrong("limit_mbit", "20.0");
  side.node.udp.max_bytes_per_s = static_cast<std::uint64_t>(std::llround(limit_mbit * bytes_of_mbit));
}

void read_rule(const toml::table& table, Mistake& mistake, std::vector<BridgeRule>& rules) {
  std::string text;
  BridgeRuleOptions options;
  std::int64_t priority = 0;
  {
    TableReader keys(table, mistake);
    keys.read("rule", "\"points -> robot/points\"", text);
    keys.read("defaults", "[\"covariance\"]", options.defaults);
    keys.read("priority", "1", priority);
    keys.read("reliable", "true", options.reliable);
    if (text.empty()) keys.wrong("rule", "\"points -> robot/points\"");
    if (priority < -bridge_priority_most || priority > bridge_priority_most) keys.wrong("priority", "1");
  }
  options.priority = static_cast<std::int8_t>(priority);
  const Result<std::vector<BridgeRule>> ways = parse_bridge_rule(text, options);
  if (ways)
    rules.insert(rules.end(), ways->begin(), ways->end());
  else
    mistake.note(table, ways.error().message);
}

/// Returns the tables of a list [[key]]; an empty list if the key is missing or is not a list of tables.
std::vector<const toml::table*> tables_of(const toml::table& file, std::string_view key, Mistake& mistake) {
  std::vector<const toml::table*> tables;
  const toml::node* const node = file.get(key);
  if (node != nullptr && !node->is_array_of_tables())
    mistake.note(*node, fmt::format("'{0}' is no list: write [[{0}]]", key));
  else if (node != nullptr)
    for (const toml::node& one : *node->as_array()) tables.push_back(one.as_table());
  return tables;
}

bool is_plain_name(std::string_view name) {
  return !name.empty() && name.find_first_of("{}[]@<> \t~") == name.npos &&
         std::ranges::count(name, '*') <= 1;
}

}  // namespace

std::optional<NodeOptions::VanillaDds> vanilla_choice_of(std::string_view word) {
  if (word == "auto") return NodeOptions::VanillaDds::automatic;
  if (word == "always") return NodeOptions::VanillaDds::always;
  if (word == "never") return NodeOptions::VanillaDds::never;
  return std::nullopt;
}

std::optional<std::string> BridgeRule::target_of(std::string_view name) const {
  const std::size_t star = topic.find('*');
  if (star == topic.npos) return name == topic ? std::optional(target) : std::nullopt;
  const std::string_view before = std::string_view(topic).substr(0, star);
  const std::string_view behind = std::string_view(topic).substr(star + 1);
  if (name.size() < before.size() + behind.size() || !name.starts_with(before) || !name.ends_with(behind))
    return std::nullopt;
  const std::string_view middle = name.substr(before.size(), name.size() - before.size() - behind.size());
  return std::string(target).replace(target.find('*'), 1, middle);
}

Result<std::vector<BridgeRule>> parse_bridge_rule(const std::string& text, const BridgeRuleOptions& options) {
  static const std::regex form(R"(^\s*(\S.*?)\s+(<->|->|<-)\s+(\S.*?)\s*$)");
  std::smatch parts;
  const bool has_arrow = std::regex_match(text, parts, form);
  const std::string arrow = has_arrow ? parts[2].str() : "->";
  const std::string left = has_arrow ? parts[1].str() : text, right = has_arrow ? parts[3].str() : "";
  const auto wrong = [&](const std::string& what) {
    return fail(Errc::invalid_argument, "rule '" + text + "': " + what);
  };
  const bool is_backward = arrow == "<-";
  const Result<TopicSelection> source = parse_topic_selection(is_backward ? right : left);
  if (!source) return wrong(source.error().message);
  const std::string target = has_arrow ? Session::plain_name(is_backward ? left : right) : source->topic;
  for (const std::string& name : {source->topic, target}) {
    if (!is_plain_name(name))
      return wrong("'" + name +
                   "' is no name of a topic; write TOPIC -> NAME, NAME <- TOPIC or TOPIC <-> NAME, " +
                   "with blanks, and what is wanted of TOPIC behind it");
  }
  if (std::ranges::count(source->topic, '*') != std::ranges::count(target, '*'))
    return wrong("both names have a *, or none");
  BridgeRule way{.text = text,
                 .from = is_backward ? std::size_t{1} : 0,
                 .topic = source->topic,
                 .selection = source->text,
                 .target = target,
                 .options = options};
  std::vector<BridgeRule> ways{way};
  if (arrow == "<->") {
    std::swap(way.topic, way.target);
    way.from = 1;
    ways.push_back(std::move(way));
  }
  return ways;
}

Result<void> check_rules(const std::vector<BridgeRule>& rules) {
  for (std::size_t i = 0; i < rules.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (rules[i].from != rules[j].from || rules[i].topic != rules[j].topic ||
          rules[i].target != rules[j].target)
        continue;
      return fail(Errc::invalid_argument,
                  fmt::format("the rules '{}' and '{}' would carry '{}' to '{}' twice: remove one of them",
                              rules[j].text, rules[i].text, rules[i].topic, rules[i].target));
    }
  }
  return {};
}

Result<void> read_bridge_file(const std::string& path, BridgePlan& plan) {
  const Result<std::string> text = core::read_text_file(path);
  if (!text) return tl::unexpected(text.error());
  Mistake mistake(path);
  try {
    const toml::table file = toml::parse(*text, path);
    const auto sides = tables_of(file, "side", mistake);
    if (sides.size() != plan.sides.size())
      mistake.note(file, "write [[side]] twice: a bridge joins two sides");
    for (std::size_t i = 0; i < std::min(sides.size(), plan.sides.size()); ++i)
      read_side(*sides[i], mistake, plan.sides[i]);
    for (const toml::table* rule : tables_of(file, "rule", mistake)) read_rule(*rule, mistake, plan.rules);
    for (const auto& [key, node] : file) {
      if (key != "side" && key != "rule")
        mistake.note(node, fmt::format("'{}' is no key here; there are [[side]] and [[rule]]", key.str()));
    }
  } catch (const toml::parse_error& error) {
    return fail(Errc::invalid_argument,
                fmt::format("{}:{}: {}", path, error.source().begin.line, error.description()));
  }
  if (!mistake.text().empty()) return fail(Errc::invalid_argument, mistake.text());
  return {};
}

}  // namespace sft::tool
