// A second, simple implementation of the conditions of a gate (selection.md, "Conditions"), with which the
// runtime is compared. This implementation uses numbers of any size instead of rounding, a tree instead of
// a list of nodes, and a map of former values. It uses nothing of the runtime except the type tables and
// the Selection.
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

/// The value of a field: a number or a string.
using FieldValue = std::variant<std::int64_t, std::uint64_t, double, std::string>;
/// The values of one message, by leaf.
using FieldValues = std::map<std::uint32_t, FieldValue>;

/// A field that conditions can use: a single value outside of arrays and sequences.
struct SingleField {
  std::uint32_t leaf;
  const StructType::Member* member;
  std::size_t offset;  ///< the offset from the beginning of the message, in bytes
};
std::vector<SingleField> single_fields(const StructType& type);

/// Returns the values of these fields. A boolean is 0 or 1, an enumeration is its number, and a character is
/// the value of its byte.
FieldValues values_of(std::span<const SingleField> fields, const void* message);

/// The conditions of one gate. The caller calls holds() once for each sample, and passed() if the sample
/// passes.
class GateReference {
 public:
  using Condition = Selection::Condition;

  /// Each condition precedes its children. Without conditions, every sample passes.
  explicit GateReference(const std::vector<Condition>& conditions);

  /// Records that a reader begins. Until the next sample passes, `changed` and `every` hold, because no
  /// earlier sample counts. A new object is in this state, too.
  void begin() { begins_ = true; }
  bool begins() const { return begins_; }
  bool holds(const FieldValues& sample, std::int64_t stamp_ns);
  void passed(const FieldValues& sample, std::int64_t stamp_ns);
  /// Returns true if the last result of holds() may depend on rounding. This is so if the distance of a
  /// number from its former value and the deadband are different, but agree in their first 60 binary
  /// digits.
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
  FieldValues former_;  ///< the values of the last sample that passed
  /// The stamp of the last sample that passed, or an earlier stamp to which the clock was set back.
  std::int64_t period_from_ns_ = 0;
  bool was_close_ = false;
};

}  // namespace sft::test
