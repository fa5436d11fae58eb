// Layout rules as text, which is the content of @sft_layout. A rule says how a field is made of rows and
// columns, and which other members depend on it (runtime/selection.md, "Layout rules"). The compilers, the
// runtime and the reader of type descriptions share this file, so that all of them accept the same rules.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "sft/detail/layout.h"

namespace sft::layout {

using Form = detail::Layout::Form;
using Role = detail::LayoutRole;

/// The word with which a rule begins in comments of .msg files. In IDL, it is the annotation of a member.
inline constexpr std::string_view annotation = "@sft_layout";
inline constexpr std::size_t rule_bytes_max = 255;
inline constexpr std::size_t also_max = 16;   ///< the maximum number of other fields that share a rule
inline constexpr std::size_t rules_max = 64;  ///< the maximum number of rules in one struct

/// One rule, `rows=height columns=width`. Paths are relative to the struct of the annotated field.
struct Rule {
  struct Path {
    std::string text;    ///< the text of the path, such as "info.width"
    std::size_t at = 0;  ///< the position of the path in the rule, in bytes from 0
  };

  Form form = Form::list;
  std::array<std::optional<Path>, detail::layout_roles> roles{};
  std::vector<Path> also{};  ///< other fields, of which the same part is taken as of this field

  const std::optional<Path>& operator[](Role role) const { return roles[static_cast<std::size_t>(role)]; }
  /// Returns the canonical spelling of the rule: roles in the order of LayoutRole, separated by one blank.
  std::string text() const;
};

/// A mistake in a rule, with a text that says what to do.
struct Fault {
  std::size_t member = 0;  ///< the number of the annotated member in its struct
  std::size_t at = 0;      ///< the position in the text of the rule, in bytes from 0
  std::string text;
};

/// Reads a rule. Checks only what can be checked without the type: whether the roles suit each other.
tl::expected<Rule, Fault> read_rule(std::string_view text);

/// The properties of a struct's member that rules use.
struct SeenMember {
  std::string_view name;
  detail::Kind kind{};
  detail::Shape shape{};
  /// An argument for SeenTypes::member(); null: the member is no structure, or its type is not known here.
  const void* type = nullptr;
};

/// The structs in which the members of a rule are looked up.
class SeenTypes {
 public:
  virtual ~SeenTypes() = default;
  /// Returns member number `i` of a struct, from 0; nothing if the struct has no such member.
  virtual std::optional<SeenMember> member(const void* type, std::size_t i) const = 0;
};

/// The members of types that are compiled in or were made from a description.
class SeenStructTypes : public SeenTypes {
 public:
  std::optional<SeenMember> member(const void* type, std::size_t i) const override {
    const auto& members = static_cast<const StructType*>(type)->members;
    if (i >= members.size()) return {};
    return SeenMember{members[i].name, members[i].kind, members[i].shape, members[i].type};
  }
};

struct RuleOfMember {
  std::size_t member;
  const Rule* rule;
};

/// Returns the first fault in the rules of one struct: a member that the struct lacks or that has another
/// kind, or a member that two rules would rewrite.
std::optional<Fault> check_rules(const SeenTypes& types, const void* type,
                                 std::span<const RuleOfMember> rules);

}  // namespace sft::layout
