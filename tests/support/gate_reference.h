// This file says a second time, and in the plainest way, which samples fulfil the conditions of a gate
// (selection.md, "Conditions"), to compare the runtime with: numbers of any size instead of rounding, a tree
// instead of a list of nodes, and a map of former values. Nothing of the runtime is used but the tables, and
// the value of a Selection.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "sft/detail/type_table.h"
#include "sft/selection.h"

namespace sft::test {

/// The value of a field: a number or a text.
using FieldValue = std::variant<std::int64_t, std::uint64_t, double, std::string>;
/// The values of one message, by leaf.
using FieldValues = std::map<std::uint32_t, FieldValue>;

/// A field that conditions can be on: a single value that is in no array and no sequence.
struct SingleField {
  std::uint32_t leaf;
  const StructType::Member* member;
  std::size_t offset;  ///< from the beginning of the message
};
std::vector<SingleField> single_fields(const StructType& type);

/// Its single values: a boolean is 0 or 1, an enumeration its number, a character that of its byte.
FieldValues values_of(std::span<const SingleField> fields, const void* message);

/// The conditions of one gate. A sample is asked about once; if it passes, passed() is called for it.
class GateReference {
 public:
  using Condition = Selection::Condition;

  /// Each condition before its children; none: every sample fulfils them.
  explicit GateReference(const std::vector<Condition>& conditions);

  /// A reader begins: until a sample passes, `changed` and `every` hold, since there is no earlier sample. It
  /// is so from the start.
  void begin() { begins_ = true; }
  bool begins() const { return begins_; }
  bool holds(const FieldValues& sample, std::int64_t stamp_ns);
  void passed(const FieldValues& sample, std::int64_t stamp_ns);
  /// True if the last answer may depend on rounding: a number was not just as far from its former value as a
  /// deadband permits, but was so to 60 binary digits.
  bool was_close() const { return was_close_; }

 private:
  struct Node {
    Condition condition;
    std::vector<Node> children{};
  };
  static Node tree(const std::vector<Condition>& conditions, std::size_t& next);
  bool holds(const Node& node, const FieldValues& sample, std::int64_t stamp_ns);
  bool has_changed(const Condition& condition, const FieldValues& sample);

  std::optional<Node> root_;
  std::uint64_t asked_about_ = 0;
  bool begins_ = true;
  FieldValues former_;               ///< of the last sample that passed
  std::int64_t period_from_ns_ = 0;  ///< its stamp, or an earlier one that the clock was set back to
  bool was_close_ = false;
};

}  // namespace sft::test
