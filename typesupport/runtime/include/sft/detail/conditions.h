// Decides which samples of a stream fulfil the conditions of a gate (selection.md, "Conditions"). Pure:
// fields and stamps are passed in, decisions are returned.
//
// Fields are read at their original place: in the message that the program publishes, before anything of it
// is encoded, or in a sample that arrived encoded. Nothing is allocated for a sample. Of a text that is
// compared, only the length and a hash are stored.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "sft/detail/walk.h"
#include "sft/result.h"
#include "sft/selection.h"

namespace sft::detail {

/// The source of the fields of one sample. Owns nothing.
class FieldSource {
 public:
  /// Makes the source of a message of the program, which must have the type of the conditions.
  static FieldSource of_message(const void* message) {
    return {static_cast<const std::byte*>(message), nullptr};
  }
  /// Makes the source of a message that is in another struct than the generated struct of its type
  /// (struct_in.h).
  static FieldSource of_other_struct(const Message& message) {
    return {static_cast<const std::byte*>(message.value), nullptr, &message.type};
  }
  /// Makes the source of an unknown message: its numbers count as 0, and its texts as empty.
  static FieldSource of_nothing() { return {nullptr, nullptr}; }
  /// Makes the source of an encoded sample with an index.
  static FieldSource of_sample(const SampleState& sample) { return {nullptr, &sample}; }

 private:
  friend class Conditions;
  FieldSource(const std::byte* message, const SampleState* sample, const StructType* other = nullptr)
      : message_(message), sample_(sample), other_(other) {}
  const std::byte* message_;
  const SampleState* sample_;  ///< the encoded sample; null: message_ is used
  /// the places of the fields in message_; null: they are those of the generated struct
  const StructType* other_;
};

/// The conditions of one gate, and the values from the last sample that passed which these conditions need.
/// Not thread-safe.
class Conditions {
 public:
  using Condition = Selection::Condition;

  /// Returns an error if a condition refers to anything but a single value of the type. Must be called for
  /// conditions from another process.
  static Result<void> check(const StructType& type, std::span<const Condition> conditions);

  /// Makes an object without conditions, for which hold() always returns true.
  Conditions() = default;
  /// Makes conditions for messages of `type`. REQUIRES: check() has accepted the conditions.
  Conditions(const StructType& type, std::vector<Condition> conditions);

  bool empty() const { return conditions_.empty(); }
  /// Starts anew for a reader that has received no earlier sample. Until a sample has passed, all
  /// conditions about earlier samples (`changed`, `every`) hold. A new object is in this state, too.
  void begin() { begins_ = true; }
  /// Returns true until a sample has passed since begin().
  bool begins() const { return begins_; }
  /// Returns true if the conditions hold for this sample, which is the next sample of the stream. Must be
  /// called once per sample.
  bool hold(const FieldSource& sample, std::int64_t stamp_ns);
  /// Notes that the sample of the last call of hold() has passed. Later samples are compared with this
  /// sample.
  void passed(const FieldSource& sample, std::int64_t stamp_ns);

 private:
  /// A field to which conditions refer.
  struct Field {
    Kind kind{};
    std::uint32_t leaf = 0;
    std::size_t slot = 0;
    std::size_t offset = 0;  ///< the offset in the generated struct
    // The value in the last sample that passed. Set only for fields whose conditions compare with this
    // value.
    std::uint64_t bits = 0;  ///< the bits of a number; a hash of a text
    std::size_t length = 0;  ///< the length of a text
  };
  struct Node {
    Condition condition;
    std::vector<std::size_t> fields{};  ///< one index into fields_ for each leaf of the condition
    std::size_t end = 0;                ///< the index of the node that follows the last child
  };

  std::size_t enter(const StructType& type, std::uint32_t leaf);
  std::size_t enter_children(std::size_t node);
  bool holds(std::size_t node, const FieldSource& sample, std::int64_t stamp_ns) const;
  bool holds_of_children(const Node& node, std::size_t first, const FieldSource& sample,
                         std::int64_t stamp_ns) const;
  bool compares(const Node& node, const FieldSource& sample) const;
  static bool has_changed(const Field& field, const Condition& condition, const FieldSource& sample);
  static const std::byte* find(const Field& field, const FieldSource& sample);
  static const std::byte* find_in_message(const Field& field, const FieldSource& sample);
  static std::uint64_t bits_at(const Field& field, const FieldSource& sample);
  static std::string_view text_at(const Field& field, const FieldSource& sample);

  std::vector<Node> conditions_;  ///< the nodes; each node stands before its children
  std::vector<Field> fields_;
  bool begins_ = true;
  std::uint64_t samples_ = 0;      ///< number of samples for which hold() was called
  std::int64_t passed_at_ns_ = 0;  ///< the stamp of the last sample that passed
};

}  // namespace sft::detail
