#include "sft/selection.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string>
#include <string_view>
#include <utility>
#include <variant>

#include "selection_bytes.h"
#include "sft/detail/fnv1a.h"
#include "sft/detail/text.h"

namespace sft {

namespace {

using Condition = Selection::Condition;
using Part = Selection::Part;
using Range = Selection::Range;

const Selection::Gate open_gate;
const Selection::Number no_number = std::uint64_t{0};

/// A condition with its children.
struct Tree {
  Condition node;
  std::vector<Tree> children{};
};

bool has_children(Condition::Kind kind) {
  return kind == Condition::Kind::all_of || kind == Condition::Kind::any_of;
}

std::size_t nodes_of(const Tree& tree) {
  std::size_t nodes = 1;
  for (const Tree& child : tree.children) nodes += nodes_of(child);
  return nodes;
}

void append(const Tree& tree, std::vector<Condition>& to) {
  to.push_back(tree.node);
  to.back().children = static_cast<std::uint32_t>(tree.children.size());
  for (const Tree& child : tree.children) append(child, to);
}

/// Returns bytes by which conditions are sorted. They begin with the kind, so that conditions of one kind
/// are neighbours.
std::vector<std::byte> order_of(const Tree& tree) {
  std::vector<Condition> conditions;
  append(tree, conditions);
  std::vector<std::byte> bytes{static_cast<std::byte>(tree.node.kind)};
  for (const Condition& condition : conditions) detail::put(bytes, condition);
  return bytes;
}

/// Removes the tree at the front of the conditions, and returns the tree.
Result<Tree> take_tree(std::span<const Condition>& conditions, std::size_t depth) {
  if (conditions.empty()) return fail(Errc::invalid_argument, "'and' or 'or' lacks a condition");
  if (depth > Selection::depth_max)
    return fail(Errc::invalid_argument,
                "conditions lie at most " + std::to_string(Selection::depth_max) + " deep in each other");
  Tree tree{conditions.front()};
  conditions = conditions.subspan(1);
  for (std::uint32_t i = 0; i < tree.node.children; ++i) {
    Result<Tree> child = take_tree(conditions, depth + 1);
    if (!child) return child;
    tree.children.push_back(std::move(*child));
  }
  return tree;
}

/// Returns the canonical form of the tree, which all equal conditions share: no `and` directly in an `and`,
/// children in one order and each once, and no node with a single child.
Tree canonical(Tree tree) {
  Condition& node = tree.node;
  if (node.kind != Condition::Kind::compare) node.comparison = {};
  const bool has_deadband = node.kind == Condition::Kind::changed && node.number != no_number;
  node.is_percent = node.is_percent && has_deadband;
  if (node.kind != Condition::Kind::changed && node.kind != Condition::Kind::compare) node.leaves.clear();
  if (!has_children(node.kind)) {
    std::ranges::sort(node.leaves);
    node.leaves.erase(std::ranges::unique(node.leaves).begin(), node.leaves.end());
    return tree;
  }
  node.number = no_number;
  std::vector<std::pair<std::vector<std::byte>, Tree>> children;
  for (Tree& child : tree.children) {
    Tree clean = canonical(std::move(child));
    if (clean.node.kind == tree.node.kind) {
      for (Tree& inner : clean.children) children.emplace_back(order_of(inner), std::move(inner));
    } else {
      std::vector<std::byte> order = order_of(clean);
      children.emplace_back(std::move(order), std::move(clean));
    }
  }
  const auto by_order = [](const auto& one) -> const std::vector<std::byte>& { return one.first; };
  std::ranges::sort(children, {}, by_order);
  children.erase(std::ranges::unique(children, {}, by_order).begin(), children.end());
  if (children.size() == 1) return std::move(children.front().second);
  tree.children.clear();
  for (auto& [order, child] : children) tree.children.push_back(std::move(child));
  return tree;
}

bool is_finite(const Selection::Number& number) {
  const auto* real = std::get_if<double>(&number);
  return real == nullptr || std::isfinite(*real);
}

bool is_negative(const Selection::Number& number) {
  return std::visit([](auto value) { return value < 0; }, number);
}

/// Returns the number as an integer if an integer can hold it. Only a negative integer is signed.
Selection::Number canonical(const Selection::Number& number) {
  if (const auto* whole = std::get_if<std::int64_t>(&number); whole != nullptr && *whole >= 0)
    return static_cast<std::uint64_t>(*whole);
  const auto* real = std::get_if<double>(&number);
  if (real == nullptr || std::trunc(*real) != *real) return number;
  constexpr double end_of_signed = 0x1p63;
  if (*real >= 0 && *real < 2 * end_of_signed) return static_cast<std::uint64_t>(*real);
  if (*real < 0 && *real >= -end_of_signed) return static_cast<std::int64_t>(*real);
  return number;
}

/// Returns a text about the mistake in the condition; empty if the condition has no mistake.
std::string fault_of(const Condition& condition, std::size_t leaves) {
  const auto exists = [leaves](std::uint32_t leaf) { return leaf < leaves; };
  if (!std::ranges::all_of(condition.leaves, exists)) return "a condition is on a field that the type lacks";
  const auto* count = std::get_if<std::uint64_t>(&condition.number);
  if (!has_children(condition.kind) && condition.children > 0)
    return "only 'and' and 'or' have conditions in them";
  switch (condition.kind) {
    case Condition::Kind::all_of:
    case Condition::Kind::any_of:
      return condition.children == 0 ? "'and' and 'or' need conditions to stand between" : "";
    case Condition::Kind::compare:
      if (condition.leaves.size() != 1) return "a comparison is of one field";
      if (condition.comparison > Condition::Comparison::not_equal) return "there is no such comparison";
      return is_finite(condition.number) ? "" : "a field is compared with a finite number";
    case Condition::Kind::changed:
      if (condition.leaves.empty()) return "'changed' needs a field";
      if (condition.leaves.size() > Selection::changed_leaves_max)
        return "'changed' takes at most " + std::to_string(Selection::changed_leaves_max) + " fields";
      if (is_finite(condition.number) && !is_negative(condition.number)) return "";
      return "a deadband is a finite number from 0 on";
    case Condition::Kind::nth:
      return count != nullptr && *count > 0 ? "" : "samples are counted from the 1st on";
    case Condition::Kind::elapsed: {
      const auto longest = static_cast<std::uint64_t>(Selection::period_max.count());
      return count != nullptr && *count > 0 && *count <= longest ? "" : "a period is from 1 us to 24 hours";
    }
  }
  return "there is no such condition";
}

Result<std::vector<Condition>> canonical(std::vector<Condition> conditions, std::size_t leaves) {
  if (conditions.empty()) return conditions;
  for (Condition& condition : conditions) {
    condition.number = canonical(condition.number);
    if (const std::string fault = fault_of(condition, leaves); !fault.empty())
      return fail(Errc::invalid_argument, fault);
  }
  std::span<const Condition> rest = conditions;
  Result<Tree> tree = take_tree(rest, 1);
  if (!tree) return tl::unexpected(tree.error());
  if (!rest.empty()) return fail(Errc::invalid_argument, "conditions beside each other");
  const Tree clean = canonical(std::move(*tree));
  if (nodes_of(clean) > Selection::conditions_max)
    return fail(Errc::limit_exceeded,
                "more than " + std::to_string(Selection::conditions_max) + " conditions");
  std::vector<Condition> result;
  append(clean, result);
  return result;
}

/// Returns true if the text of a selection can contain the name.
bool is_readable_channel(std::string_view name) {
  return name.find_first_of(",}") == std::string_view::npos && name.front() != ' ' && name.back() != ' ' &&
         detail::is_printable(name);
}

/// Returns a text about the mistake in the canonical part; empty if the part has no mistake.
std::string fault_of(const Part& part, std::size_t leaves) {
  if (part.leaf >= leaves) return "a part is of a field that the type lacks";
  if (part.channels.size() > Selection::channels_max)
    return "more than " + std::to_string(Selection::channels_max) + " channels";
  const auto is_name = [](const std::string& name) {
    return !name.empty() && name.size() <= Selection::channel_bytes_max;
  };
  if (!std::ranges::all_of(part.channels, is_name))
    return "the name of a channel has 1 to " + std::to_string(Selection::channel_bytes_max) + " bytes";
  if (!std::ranges::all_of(part.channels, is_readable_channel))
    return "the name of a channel is printable, and has no ',', no '}' and no blank at its ends";
  return "";
}

Part canonical(Part part) {
  part.rows = part.rows.canonical();
  part.columns = part.columns.canonical();
  std::ranges::sort(part.channels);
  part.channels.erase(std::ranges::unique(part.channels).begin(), part.channels.end());
  return part;
}

std::uint64_t hash_of(std::span<const std::byte> bytes) {
  detail::Fnv1a hash;
  hash.add(std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
  return hash.value();
}

bool has_same_cells(const Part& a, const Part& b) { return a.rows == b.rows && a.columns == b.columns; }

/// Returns the part of a leaf that contains both parts.
Part joined(const Part& a, const Part& b) {
  Part both{.leaf = a.leaf, .rule = a.rule};
  if (a.rule != b.rule) return both;
  if (has_same_cells(a, b)) {
    both.rows = a.rows;
    both.columns = a.columns;
  }
  if (a.channels.empty() || b.channels.empty()) return both;
  std::ranges::set_union(a.channels, b.channels, std::back_inserter(both.channels));
  return both;
}

}  // namespace

std::uint32_t Range::size_of(std::uint32_t count) const {
  const std::uint32_t last = std::min(end, count);
  return begin >= last ? 0 : (last - 1 - begin) / step + 1;
}

Range Range::canonical() const {
  if (is_empty()) return {.begin = 0, .end = 0, .step = 1};
  if (end == no_end && no_end - begin > step) return *this;
  const std::uint32_t last = begin + (end - 1 - begin) / step * step;
  return {.begin = begin, .end = last + 1, .step = last == begin ? 1 : step};
}

Range Range::then(const Range& inner) const {
  constexpr Range none{.begin = 0, .end = 0, .step = 1};
  if (is_empty() || inner.is_empty()) return none;
  const std::uint64_t first = begin + std::uint64_t{inner.begin} * step;
  if (first >= end) return none;
  std::uint64_t last = end;
  if (inner.end != no_end) last = std::min(last, begin + (std::uint64_t{inner.end} - 1) * step + 1);
  const std::uint64_t both = std::uint64_t{step} * inner.step;
  Range result{.begin = static_cast<std::uint32_t>(first), .end = static_cast<std::uint32_t>(last)};
  if (both >= no_end) {  // the second index would exceed 32 bits
    result.end = result.begin + 1;
  } else {
    result.step = static_cast<std::uint32_t>(both);
  }
  return result.canonical();
}

Result<Selection> Selection::make(FieldMask mask, std::vector<Part> parts, Gate gate) {
  auto extra = std::make_shared<Extra>();
  const std::size_t leaves = mask.leaves();
  for (Part& part : parts) {
    if (part.rows.step == 0 || part.columns.step == 0)
      return fail(Errc::invalid_argument, "a step of 0 keeps nothing; steps count from 1");
    part = sft::canonical(std::move(part));
    if (const std::string fault = fault_of(part, leaves); !fault.empty())
      return fail(Errc::invalid_argument, fault);
    mask.insert(part.leaf);
  }
  std::ranges::sort(parts, {}, &Part::leaf);
  if (std::ranges::adjacent_find(parts, {}, &Part::leaf) != parts.end())
    return fail(Errc::invalid_argument, "two parts of one field");
  std::erase_if(parts, [](const Part& part) { return part.is_whole(); });
  if (parts.size() > parts_max)
    return fail(Errc::limit_exceeded, "parts of more than " + std::to_string(parts_max) + " fields");
  if (gate.least_period.count() < 0 || gate.least_period > period_max)
    return fail(Errc::invalid_argument, "a period is from 1 us to 24 hours");
  Result<std::vector<Condition>> conditions = sft::canonical(std::move(gate.conditions), leaves);
  if (!conditions) return tl::unexpected(conditions.error());
  gate.conditions = std::move(*conditions);
  Selection selection(std::move(mask));
  if (parts.empty() && gate.is_open()) return selection;
  extra->parts = std::move(parts);
  extra->gate = std::move(gate);
  if (!extra->parts.empty()) extra->parts_hash = hash_of(detail::bytes_of(extra->parts));
  if (!extra->gate.is_open())
    extra->gate_hash = std::max<std::uint64_t>(hash_of(detail::bytes_of(extra->gate)), 1);
  selection.extra_ = std::move(extra);
  if (selection.to_bytes().size() > bytes_max)
    return fail(Errc::limit_exceeded,
                "it takes more than " + std::to_string(bytes_max) + " bytes; name fewer or shorter channels");
  return selection;
}

std::span<const Part> Selection::parts() const {
  return extra_ == nullptr ? std::span<const Part>{} : std::span<const Part>(extra_->parts);
}

const Part* Selection::part(std::size_t leaf) const {
  const std::span<const Part> all = parts();
  const auto found = std::ranges::find(all, leaf, &Part::leaf);
  return found == all.end() ? nullptr : &*found;
}

const Selection::Gate& Selection::gate() const { return extra_ == nullptr ? open_gate : extra_->gate; }

Result<Selection> Selection::with_gate(Gate gate) const {
  return make(mask_, {parts().begin(), parts().end()}, std::move(gate));
}

Selection Selection::without_gate() const {
  if (gate().is_open()) return *this;
  Selection result(mask_);
  if (parts().empty()) return result;
  auto extra = std::make_shared<Extra>();
  extra->parts = extra_->parts;
  extra->parts_hash = extra_->parts_hash;
  result.extra_ = std::move(extra);
  return result;
}

Selection Selection::without_rate() const {
  if (gate().least_period.count() == 0) return *this;
  return with_gate({gate().conditions, {}}).value();  // cannot exceed a limit, since the gate is shorter
}

Selection Selection::joined(const Selection& other) const {
  if (*this == other) return *this;
  std::vector<Part> both;
  for (const Part& part : parts()) {
    const Part* theirs = other.part(part.leaf);
    if (theirs != nullptr) {
      both.push_back(sft::joined(part, *theirs));
    } else if (!other.mask_.contains(part.leaf)) {
      both.push_back(part);
    }
  }
  for (const Part& theirs : other.parts()) {
    if (!mask_.contains(theirs.leaf)) both.push_back(theirs);
  }
  const FieldMask fields = mask_ | other.mask_;
  const Gate common = gate() == other.gate() ? gate() : Gate{};
  if (Result<Selection> result = make(fields, std::move(both), common)) return std::move(*result);
  if (Result<Selection> result = make(fields, {}, common)) return std::move(*result);
  return fields;
}

bool operator==(const Selection& a, const Selection& b) {
  if (a.mask_ != b.mask_) return false;
  if (a.extra_ == b.extra_) return true;
  if (a.extra_ == nullptr || b.extra_ == nullptr) return false;
  return a.extra_->parts == b.extra_->parts && a.extra_->gate == b.extra_->gate;
}

std::uint64_t Selection::what_hash() const {
  if (extra_ == nullptr || extra_->parts.empty()) return mask_.hash();
  detail::Fnv1a hash;
  hash.add(mask_.hash());
  hash.add(extra_->parts_hash);
  return hash.value();
}

std::uint64_t Selection::gate_hash() const { return extra_ == nullptr ? 0 : extra_->gate_hash; }

std::uint64_t Selection::hash() const {
  if (gate().is_open()) return what_hash();
  detail::Fnv1a hash;
  hash.add(what_hash());
  hash.add(gate_hash());
  return hash.value();
}

}  // namespace sft
