#include "sft/detail/layout.h"

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "layout/rule.h"
#include "sft/detail/fnv1a.h"
#include "sft/detail/layout_text.h"

namespace sft::detail {

namespace {

/// A struct's first leaf and slot.
struct Place {
  const StructType* type;
  std::uint32_t leaf;
  std::uint32_t slot;
};

template <class Visit>
void for_each_member(const Place& place, Visit visit) {
  Layout::Field field{place.leaf, place.slot, nullptr};
  for (const Member& member : place.type->members) {
    field.member = &member;
    visit(field);
    field.leaf += static_cast<std::uint32_t>(leaf_count(member));
    field.slot += static_cast<std::uint32_t>(slot_count(member));
  }
}

Layout::Field find(Place place, std::string_view path) {
  const std::string_view name = path.substr(0, path.find('.'));
  Layout::Field found;
  for_each_member(place, [&](const Layout::Field& field) {
    if (field.member->name == name) found = field;
  });
  if (!found || name.size() == path.size()) return found;
  if (found.member->kind != Kind::structure || found.member->shape != Shape::single) return {};
  return find({found.member->type, found.leaf, found.slot}, path.substr(name.size() + 1));
}

bool is_single(const Member& member, Kind kind) {
  return member.kind == kind && member.shape == Shape::single;
}

/// Returns the rule as a number for Selection::Part::rule. If a reader has a different number, its type has
/// another rule, and the rule of this type must not be used for its parts.
std::uint32_t hash_of(std::string_view rule) {
  Fnv1a hash;
  hash.add(rule);
  return std::max(static_cast<std::uint32_t>(hash.value() ^ hash.value() >> 32), std::uint32_t{1});
}

Layout layout_of(const Place& place, std::string_view field, const layout::Rule& rule) {
  Layout layout{.form = rule.form};
  layout.data.push_back(find(place, field));
  for (const layout::Rule::Path& path : rule.also) layout.data.push_back(find(place, path.text));
  for (std::size_t i = 0; i < layout_roles; ++i) {
    if (rule.roles[i]) layout.fields[i] = find(place, rule.roles[i]->text);
  }
  return layout;
}

/// Collects the layouts of a type. A leaf belongs to the fields of one layout at most.
class Collector {
 public:
  explicit Collector(const StructType& type) : is_taken_(type.leaves) {}

  void add(const Place& place) {
    const bool is_annotated =
        std::ranges::any_of(place.type->members, [](const Member& m) { return !m.layout.empty(); });
    for (std::size_t i = 0; i < place.type->members.size(); ++i) {
      const Member& member = place.type->members[i];
      if (!member.layout.empty()) add(place, i, member.layout, hash_of(member.layout));
    }
    for (const KnownRule& known : known_rules) {
      if (is_annotated || known.type != place.type->name) continue;
      const auto member = std::ranges::find(place.type->members, known.field, &Member::name);
      if (member == place.type->members.end()) continue;
      add(place, static_cast<std::size_t>(member - place.type->members.begin()), known.rule, 0);
    }
    for_each_member(place, [&](const Layout::Field& field) {
      if (is_single(*field.member, Kind::structure)) add({field.member->type, field.leaf, field.slot});
    });
  }

  std::vector<Layout> take() { return std::move(layouts_); }

 private:
  /// Adds the layout of a member if the rule suits the type. A type with a known name may have other
  /// members. In that case the type has no layout.
  void add(const Place& place, std::size_t member, std::string_view text, std::uint32_t hash) {
    const auto rule = layout::read_rule(text);
    if (!rule) return;
    const layout::RuleOfMember one{member, &*rule};
    if (layout::check_rules(layout::SeenStructTypes(), place.type, {&one, 1})) return;
    Layout layout = layout_of(place, place.type->members[member].name, *rule);
    layout.rule = hash;
    if (take_leaves(layout)) layouts_.push_back(std::move(layout));
  }

  bool take_leaves(const Layout& layout) {
    std::vector<std::size_t> leaves;
    const auto list = [&leaves](const Layout::Field& field) {
      for (std::size_t i = 0; field && i < leaf_count(*field.member); ++i) leaves.push_back(field.leaf + i);
    };
    std::ranges::for_each(layout.data, list);
    std::ranges::for_each(layout.fields, list);
    if (std::ranges::any_of(leaves, [this](std::size_t leaf) { return is_taken_[leaf]; })) return false;
    for (const std::size_t leaf : leaves) is_taken_[leaf] = true;
    return true;
  }

  std::vector<bool> is_taken_;
  std::vector<Layout> layouts_;
};

Layout::Field field_in(const Place& place, std::size_t leaf) {
  Layout::Field found;
  for_each_member(place, [&](const Layout::Field& field) {
    if (leaf >= field.leaf && leaf < field.leaf + leaf_count(*field.member)) found = field;
  });
  if (!found || !is_single(*found.member, Kind::structure)) return found;
  return field_in({found.member->type, found.leaf, found.slot}, leaf);
}

}  // namespace

std::optional<LayoutRole> Layout::role_of(std::size_t leaf) const {
  for (std::size_t i = 0; i < fields.size(); ++i) {
    const auto role = static_cast<LayoutRole>(i);
    const std::size_t leaves = role == LayoutRole::origin ? 3 : 1;
    if (fields[i] && leaf >= fields[i].leaf && leaf < fields[i].leaf + leaves) return role;
  }
  return {};
}

Layout::Field field_at(const StructType& type, std::size_t leaf) { return field_in({&type, 0, 0}, leaf); }

std::vector<Layout> layouts_of(const StructType& type) {
  Collector collector(type);
  collector.add({&type, 0, 0});
  return collector.take();
}

}  // namespace sft::detail
