// Decides which samples of a stream fulfil the conditions of a gate (selection.md, "Conditions"). Pure:
// fields and stamps in, answers out.
//
// Fields are read where they are: in the message that the program publishes, before anything of it is
// encoded, or in a sample that came encoded. Nothing is allocated for a sample: of a text that is compared,
// the length and a hash are remembered.
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

/// The fields of one sample. Owns nothing.
class FieldSource {
 public:
  /// A message of the program, of the type that the conditions are for.
  static FieldSource of_message(const void* message) {
    return {static_cast<const std::byte*>(message), nullptr};
  }
  /// A message of which nothing is known: its numbers count as 0, and its texts as empty.
  static FieldSource of_nothing() { return {nullptr, nullptr}; }
  /// An encoded sample with an index.
  static FieldSource of_sample(const SampleState& sample) { return {nullptr, &sample}; }

 private:
  friend class Conditions;
  FieldSource(const std::byte* message, const SampleState* sample) : message_(message), sample_(sample) {}
  const std::byte* message_;
  const SampleState* sample_;  ///< null: the message counts
};

/// The conditions of one gate, and what they remember of the samples that passed it. Used by one thread.
class Conditions {
 public:
  using Condition = Selection::Condition;

  /// An error if a condition is on anything but a single value of the type. Conditions that came from another
  /// process have to be checked.
  static Result<void> check(const StructType& type, std::span<const Condition> conditions);

  /// No conditions, which hold for each sample.
  Conditions() = default;
  /// check() has accepted the conditions.
  Conditions(const StructType& type, std::vector<Condition> conditions);

  bool empty() const { return conditions_.empty(); }
  /// A reader begins, which knows no earlier sample: until one has passed, whatever asks about earlier
  /// samples (`changed`, `every`) holds. Conditions that were just made begin, too.
  void begin() { begins_ = true; }
  /// True until a sample has passed since begin().
  bool begins() const { return begins_; }
  /// True if they hold for this sample, which is the next one of the stream. Each sample is asked about once.
  bool hold(const FieldSource& sample, std::int64_t stamp_ns);
  /// The sample that was asked about last has passed: later ones are compared with it.
  void passed(const FieldSource& sample, std::int64_t stamp_ns);

 private:
  /// A field that some condition is on.
  struct Field {
    Kind kind{};
    std::uint32_t leaf = 0;
    std::size_t slot = 0;
    std::size_t offset = 0;  ///< from the beginning of a message of the program
    // In the last sample that passed; only of fields that are compared with it:
    std::uint64_t bits = 0;  ///< of a number; of a text a hash
    std::size_t length = 0;  ///< of a text
  };
  struct Node {
    Condition condition;
    std::vector<std::size_t> fields{};  ///< of fields_: one for each leaf of the condition
    std::size_t end = 0;                ///< behind the children
  };

  std::size_t enter(const StructType& type, std::uint32_t leaf);
  std::size_t enter_children(std::size_t node);
  bool holds(std::size_t node, const FieldSource& sample, std::int64_t stamp_ns) const;
  bool holds_of_children(const Node& node, std::size_t first, const FieldSource& sample,
                         std::int64_t stamp_ns) const;
  bool compares(const Node& node, const FieldSource& sample) const;
  static bool has_changed(const Field& field, const Condition& condition, const FieldSource& sample);
  static const std::byte* find(const Field& field, const FieldSource& sample);
  static std::uint64_t bits_at(const Field& field, const FieldSource& sample);
  static std::string_view text_at(const Field& field, const FieldSource& sample);

  std::vector<Node> conditions_;  ///< each before its children
  std::vector<Field> fields_;
  bool begins_ = true;
  std::uint64_t samples_ = 0;      ///< that were asked about
  std::int64_t passed_at_ns_ = 0;  ///< the stamp of the last sample that passed
};

}  // namespace sft::detail
