#include "layout/rule.h"

#include <algorithm>
#include <map>
#include <utility>

namespace sft::layout {

using detail::Kind;
using detail::Shape;

namespace {

using Path = Rule::Path;

constexpr std::array<std::string_view, detail::layout_roles> role_names{
    "rows",  "columns", "cell_bytes", "row_bytes", "channels", "byte_order", "encoding",
    "scale", "origin",  "first",      "last",      "step",     "interval"};
constexpr std::string_view also_name = "also";

std::string_view name_of(Role role) { return role_names[static_cast<std::size_t>(role)]; }

std::string in_quotes(std::string_view text) {
  constexpr std::size_t most = 60;
  const bool is_plain =
      std::ranges::all_of(text, [](char c) { return c >= ' ' && c <= '~'; }) && !text.empty();
  return is_plain ? "'" + std::string(text.substr(0, most)) + "'" : "this";
}

tl::unexpected<Fault> fault(std::size_t at, std::string text) {
  return tl::unexpected(Fault{0, at, std::move(text)});
}

bool is_path(std::string_view text) {
  bool is_begin = true;
  for (const char c : text) {
    const bool is_letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
    const bool is_digit = c >= '0' && c <= '9';
    if (is_begin ? !is_letter : !is_letter && !is_digit && c != '.') return false;
    is_begin = c == '.';
  }
  return !is_begin;
}

/// Reads the words of a rule one after the other.
class Reader {
 public:
  explicit Reader(std::string_view text) : text_(text) {}

  tl::expected<Rule, Fault> run() {
    if (text_.size() > rule_bytes_max)
      return fault(0, "a layout has at most " + std::to_string(rule_bytes_max) + " bytes");
    std::size_t words = 0;
    for (;; ++words) {
      at_ = std::min(text_.find_first_not_of(' ', at_), text_.size());
      if (at_ == text_.size()) break;
      const std::string_view word = text_.substr(at_, text_.find(' ', at_) - at_);
      if (auto wrong = take(word)) return tl::unexpected(*std::move(wrong));
      at_ += word.size();
    }
    if (words == 0) return fault(0, "a layout names roles, as in rows=height columns=width");
    return std::move(rule_);
  }

 private:
  std::optional<Fault> take(std::string_view word) {
    const std::size_t sign = word.find('=');
    const std::string_view name = word.substr(0, sign);
    const auto known = std::ranges::find(role_names, name);
    if (sign == word.npos || (known == role_names.end() && name != also_name))
      return Fault{0, at_,
                   in_quotes(name) + " is no role: expected role=member, and the roles are " + roles()};
    const std::size_t behind = at_ + sign + 1;
    if (name == also_name) return take_also(word.substr(sign + 1), behind);
    std::optional<Path>& place = rule_.roles[static_cast<std::size_t>(known - role_names.begin())];
    if (place) return Fault{0, at_, std::string(name) + " is given twice"};
    auto path = path_of(word.substr(sign + 1), behind);
    if (!path) return path.error();
    place = *std::move(path);
    return {};
  }

  std::optional<Fault> take_also(std::string_view list, std::size_t at) {
    if (!rule_.also.empty()) return Fault{0, at_, "also is given twice: separate its members by commas"};
    for (;;) {
      const std::string_view one = list.substr(0, list.find(','));
      auto path = path_of(one, at);
      if (!path) return path.error();
      rule_.also.push_back(*std::move(path));
      if (rule_.also.size() > also_max)
        return Fault{0, at, "also names at most " + std::to_string(also_max) + " members"};
      if (one.size() == list.size()) return {};
      at += one.size() + 1;
      list.remove_prefix(one.size() + 1);
    }
  }

  static tl::expected<Path, Fault> path_of(std::string_view text, std::size_t at) {
    if (!is_path(text))
      return fault(at, in_quotes(text) +
                           " is not the name of a member: expected one such as width or info.width, without "
                           "blanks around '='");
    return Path{std::string(text), at};
  }

  static std::string roles() {
    std::string text;
    for (const std::string_view name : role_names) text += std::string(name) + ", ";
    return text + std::string(also_name);
  }

  std::string_view text_;
  std::size_t at_ = 0;
  Rule rule_;
};

/// A role, and another role that it needs or excludes.
struct Tie {
  Role role;
  Role other;
};
constexpr Tie needs[] = {
    {Role::rows, Role::columns},       {Role::cell_bytes, Role::columns},  {Role::row_bytes, Role::rows},
    {Role::channels, Role::columns},   {Role::channels, Role::cell_bytes}, {Role::byte_order, Role::columns},
    {Role::encoding, Role::row_bytes}, {Role::scale, Role::rows},          {Role::origin, Role::scale}};
constexpr Tie excludes[] = {{Role::encoding, Role::cell_bytes}, {Role::encoding, Role::channels},
                            {Role::scale, Role::channels},      {Role::first, Role::columns},
                            {Role::last, Role::columns},        {Role::step, Role::columns},
                            {Role::interval, Role::columns}};

std::optional<Fault> fault_of_roles(const Rule& rule) {
  const auto wrong = [&rule](Role role, const std::string& text) {
    const std::string name(name_of(role));
    return Fault{0, rule[role]->at - name.size() - 1, name + text};  // the mistake is at the role's name
  };
  for (const auto& [role, other] : needs) {
    if (rule[role] && !rule[other])
      return wrong(role, " needs " + std::string(name_of(other)) + " beside it");
  }
  for (const auto& [role, other] : excludes) {
    if (rule[role] && rule[other])
      return wrong(role, " contradicts " + std::string(name_of(other)) + ": leave one of them out");
  }
  if (rule[Role::channels] && !rule.also.empty())
    return Fault{0, rule.also.front().at, "also contradicts channels: leave one of them out"};
  return {};
}

bool is_within(std::string_view path, std::string_view outer) {
  return path.starts_with(outer) && (path.size() == outer.size() || path[outer.size()] == '.');
}

std::optional<Fault> fault_of_repetition(const Rule& rule) {
  std::vector<std::pair<std::string_view, std::string_view>> known;
  const auto enter = [&](const Path& path, std::string_view role) -> std::optional<Fault> {
    for (const auto& [other, its_role] : known) {
      if (is_within(path.text, other) || is_within(other, path.text))
        return Fault{0, path.at, in_quotes(path.text) + " is " + std::string(its_role) + " already"};
    }
    known.emplace_back(path.text, role);
    return {};
  };
  for (std::size_t i = 0; i < rule.roles.size(); ++i) {
    if (!rule.roles[i]) continue;
    if (auto wrong = enter(*rule.roles[i], role_names[i])) return wrong;
  }
  for (const Path& path : rule.also) {
    if (auto wrong = enter(path, also_name)) return wrong;
  }
  return {};
}

bool is_single(const std::optional<SeenMember>& member, Kind kind) {
  return member && member->kind == kind && member->shape == Shape::single;
}

/// Checks one rule of a struct.
class Checker {
 public:
  Checker(const SeenTypes& types, const void* type, const RuleOfMember& one)
      : types_(types), type_(type), rule_(*one.rule), index_(one.member) {}

  std::optional<Fault> run() const {
    const std::optional<SeenMember> field = types_.member(type_, index_);
    if (!field || !is_numbers(*field))
      return wrong(0, "a layout belongs to a sequence of numbers, outside of all other sequences");
    if (auto found = fault_of_bytes(*field, 0)) return found;
    for (std::size_t i = 0; i < rule_.roles.size(); ++i) {
      if (!rule_.roles[i]) continue;
      const auto member = find(*rule_.roles[i]);
      if (!member) return member.error();
      const auto role = static_cast<Role>(i);
      if (!fits(*member, role))
        return wrong(rule_.roles[i]->at, in_quotes(rule_.roles[i]->text) + " is not " + wanted(role) +
                                             ", which " + std::string(name_of(role)) + " has to be");
    }
    for (const Path& path : rule_.also) {
      if (auto found = fault_of_other(path, field->name)) return found;
    }
    return {};
  }

 private:
  Fault wrong(std::size_t at, std::string text) const { return {index_, at, std::move(text)}; }

  static bool is_numbers(const SeenMember& member) {
    return detail::is_primitive(member.kind) && member.shape == Shape::sequence;
  }

  std::optional<Fault> fault_of_bytes(const SeenMember& field, std::size_t at) const {
    if (detail::size_of(field.kind) == 1) return {};
    for (const Role role : {Role::cell_bytes, Role::row_bytes}) {
      if (rule_[role])
        return wrong(at, std::string(name_of(role)) +
                             " counts bytes, so the field has to be a sequence of uint8 or octet");
    }
    return {};
  }

  std::optional<Fault> fault_of_other(const Path& path, std::string_view own_name) const {
    if (path.text == own_name) return wrong(path.at, "also names other fields than the annotated one");
    const auto member = find(path);
    if (!member) return member.error();
    if (!is_numbers(*member)) return wrong(path.at, in_quotes(path.text) + " is not a sequence of numbers");
    return fault_of_bytes(*member, path.at);
  }

  tl::expected<SeenMember, Fault> find(const Path& path) const {
    const void* type = type_;
    std::string_view rest = path.text;
    for (;;) {
      const std::string_view name = rest.substr(0, rest.find('.'));
      const std::optional<SeenMember> found = find(type, name);
      if (!found) return tl::unexpected(wrong(path.at, "there is no member " + in_quotes(path.text)));
      if (name.size() == rest.size()) return *found;
      if (found->kind != Kind::structure || found->shape != Shape::single)
        return tl::unexpected(wrong(path.at, in_quotes(name) + " is not a single struct, so a layout cannot "
                                                               "name a member of it"));
      if (found->type == nullptr)
        return tl::unexpected(wrong(path.at, "the type of " + in_quotes(name) +
                                                 " is not known here: IDL can look into types of .msg and "
                                                 "IDL files, .msg only into those of .msg files"));
      type = found->type;
      rest.remove_prefix(name.size() + 1);
    }
  }

  std::optional<SeenMember> find(const void* type, std::string_view name) const {
    for (std::size_t i = 0;; ++i) {
      std::optional<SeenMember> member = types_.member(type, i);
      if (!member || member->name == name) return member;
    }
  }

  bool has_kinds(const void* type, std::span<const Kind> kinds) const {
    if (type == nullptr) return false;
    for (std::size_t i = 0; i < kinds.size(); ++i) {
      if (!is_single(types_.member(type, i), kinds[i])) return false;
    }
    return !types_.member(type, kinds.size());
  }

  bool is_pose(const void* type) const {
    constexpr std::array<Kind, 2> structs{Kind::structure, Kind::structure};
    constexpr std::array<Kind, 4> reals{Kind::float64, Kind::float64, Kind::float64, Kind::float64};
    return has_kinds(type, structs) && has_kinds(types_.member(type, 0)->type, std::span(reals).first(3)) &&
           has_kinds(types_.member(type, 1)->type, reals);
  }

  bool fits(const SeenMember& member, Role role) const {
    constexpr std::array channel{Kind::string, Kind::uint32, Kind::uint8, Kind::uint32};
    switch (role) {
      case Role::rows:
      case Role::columns:
      case Role::cell_bytes:
      case Role::row_bytes:
        return is_single(member, Kind::uint32);
      case Role::channels:
        return member.kind == Kind::structure && member.shape == Shape::sequence &&
               has_kinds(member.type, channel);
      case Role::byte_order:
        return detail::is_primitive(member.kind) && member.shape == Shape::single;
      case Role::encoding:
        return is_single(member, Kind::string);
      case Role::origin:
        return is_single(member, Kind::structure) && is_pose(member.type);
      case Role::scale:
      case Role::first:
      case Role::last:
      case Role::step:
      case Role::interval:
        return is_single(member, Kind::float32) || is_single(member, Kind::float64);
    }
    return false;
  }

  static std::string wanted(Role role) {
    switch (role) {
      case Role::channels:
        return "a sequence of structs like sensor_msgs/PointField (string, uint32, uint8, uint32)";
      case Role::byte_order:
        return "a single value";
      case Role::encoding:
        return "a single string";
      case Role::origin:
        return "a single struct like geometry_msgs/Pose (three and four float64)";
      case Role::scale:
      case Role::first:
      case Role::last:
      case Role::step:
      case Role::interval:
        return "a single float32 or float64";
      default:
        return "a single uint32";
    }
  }

  const SeenTypes& types_;
  const void* type_;
  const Rule& rule_;
  std::size_t index_;
};

}  // namespace

std::string Rule::text() const {
  std::string result;
  const auto add = [&result](std::string_view name, const std::string& value) {
    result += (result.empty() ? "" : " ") + std::string(name) + "=" + value;
  };
  for (std::size_t i = 0; i < roles.size(); ++i) {
    if (roles[i]) add(role_names[i], roles[i]->text);
  }
  std::string others;
  for (const Path& path : also) others += (others.empty() ? "" : ",") + path.text;
  if (!others.empty()) add(also_name, others);
  return result;
}

tl::expected<Rule, Fault> read_rule(std::string_view text) {
  tl::expected<Rule, Fault> rule = Reader(text).run();
  if (!rule) return rule;
  if (auto wrong = fault_of_roles(*rule)) return tl::unexpected(*std::move(wrong));
  if (auto wrong = fault_of_repetition(*rule)) return tl::unexpected(*std::move(wrong));
  rule->form = (*rule)[Role::channels] ? Form::points : (*rule)[Role::columns] ? Form::cells : Form::list;
  return rule;
}

std::optional<Fault> check_rules(const SeenTypes& types, const void* type,
                                 std::span<const RuleOfMember> rules) {
  if (rules.size() > rules_max)
    return Fault{rules[rules_max].member, 0,
                 "a struct has at most " + std::to_string(rules_max) + " layouts"};
  // By path of a member: the index of the member whose rule names it.
  std::map<std::string, std::size_t> owners;
  const auto taken = [&](const std::string& path, std::size_t member) {
    const auto [known, is_new] = owners.try_emplace(path, member);
    return !is_new && known->second != member;
  };
  for (const RuleOfMember& one : rules) {
    const std::optional<SeenMember> field = types.member(type, one.member);
    if (field) owners.try_emplace(std::string(field->name), one.member);
  }
  for (const RuleOfMember& one : rules) {
    if (auto wrong = Checker(types, type, one).run()) return wrong;
    std::vector<Path> paths = one.rule->also;
    for (const std::optional<Path>& path : one.rule->roles) {
      if (path) paths.push_back(*path);
    }
    for (const Path& path : paths) {
      if (taken(path.text, one.member))
        return Fault{
            one.member, path.at,
            in_quotes(path.text) +
                " belongs to another layout already: name all fields that share it in one, by also="};
    }
  }
  return {};
}

}  // namespace sft::layout
