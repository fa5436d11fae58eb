// A selection: which fields of a message a subscriber needs, which part of each, and when. selection.md
// defines its text form and all rules.
//
// A selection without parts and without a gate is a field mask, and costs the same: copies of it share
// nothing, and a comparison compares the masks. All other data is in one immutable object, which copies
// share. A selection is made for one message type, and has no meaning for another type. Any number of
// threads may read a selection. While a thread changes a selection, no other thread may use that selection,
// as with a FieldMask.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "sft/mask.h"
#include "sft/result.h"

namespace sft {

/// A selection of fields of a message type, whole or in part, and of samples.
class Selection {
 public:
  /// Every step-th index of [begin, end). The canonical form has begin = end = 0 and step = 1 for an empty
  /// range, step = 1 for a single index, and the least `end` that keeps the same indices.
  struct Range {
    /// The value of `end` for a range without an end.
    static constexpr std::uint32_t no_end = (std::numeric_limits<std::uint32_t>::max)();

    std::uint32_t begin = 0;     ///< the first index
    std::uint32_t end = no_end;  ///< the first index after the range; no_end: the range has no end
    std::uint32_t step = 1;      ///< the distance of two indices that are kept; at least 1

    /// Returns true if every index is kept.
    bool is_all() const { return begin == 0 && end == no_end && step == 1; }
    /// Returns true if no index is kept.
    bool is_empty() const { return begin >= end; }
    /// Returns the number of indices that the range keeps if there are `count` indices.
    std::uint32_t size_of(std::uint32_t count) const;
    /// Applies `inner` to the indices that this range keeps, and returns the result as a range of indices
    /// of the whole field. Returns an empty range if an index would be too large.
    Range then(const Range& inner) const;
    /// Returns the range in canonical form that keeps the same indices.
    Range canonical() const;
    friend bool operator==(const Range&, const Range&) = default;
  };

  /// The part of one leaf, which is an array or a sequence and is in no other sequence.
  struct Part {
    std::uint32_t leaf = 0;  ///< the number of the leaf in the type
    Range rows{};            ///< the rows that are kept; all rows if the leaf has no rows
    Range columns{};         ///< the columns that are kept; if the leaf has no rows, the elements
    /// The names of the channels that are kept, in ascending order and each once; empty: all channels. A
    /// name is printable UTF-8 without ',', '}' and outer blanks.
    std::vector<std::string> channels{};
    /// A hash of the layout rule with which the type is annotated. The rule gives rows, columns and
    /// channels their meaning. 0: the type has no rule. Set by parse_selection() and TypeSupport::closed().
    std::uint32_t rule = 0;

    /// Returns true if the part is the whole leaf.
    bool is_whole() const { return rows.is_all() && columns.is_all() && channels.empty(); }
    friend bool operator==(const Part&, const Part&) = default;
  };

  /// A number in a condition. In canonical form a whole number is an integer if 64 bits can hold it, and
  /// only a negative integer is signed.
  using Number = std::variant<std::int64_t, std::uint64_t, double>;

  /// A node of the tree of conditions: a condition, or `and` or `or` with its children, which follow it.
  struct Condition {
    /// The kind of the node, which determines the members that are used.
    enum class Kind : std::uint8_t {
      all_of,   ///< all children hold
      any_of,   ///< at least one child holds
      compare,  ///< a scalar leaf is compared with a number
      changed,  ///< a leaf differs from its value in the last sample that passed
      /// Each n-th sample of the stream, from the first sample on; all samples count, whether they pass or
      /// not.
      nth,
      elapsed  ///< no sample has passed for a period
    };
    /// The relation between the field and the number.
    enum class Comparison : std::uint8_t { less, less_or_equal, greater, greater_or_equal, equal, not_equal };

    Kind kind{};              ///< the kind of the node
    Comparison comparison{};  ///< the comparison of a `compare` condition
    /// True if the deadband of `changed` is a percentage of the former value. False if the deadband is 0.
    bool is_percent = false;
    /// In `compare`, one leaf. In `changed`, the leaves in ascending order, each once.
    std::vector<std::uint32_t> leaves{};
    std::uint32_t children = 0;  ///< the number of children of all_of and any_of: at least two
    /// The number in `compare`, the deadband in `changed`, n in `nth`, and the microseconds in `elapsed`.
    Number number{std::uint64_t{0}};
    friend bool operator==(const Condition&, const Condition&) = default;
  };

  /// The gate decides which samples are sent. Changes are relative to the last sample that passed, as for
  /// ON_CHANGE in gNMI, whose heartbeat is `elapsed` here. The deadband is that of OPC UA part 4, section
  /// 7.22.2, except that a deadband in percent refers to the former value. After a new request, `changed`,
  /// `nth` and `elapsed` are true until a sample has passed. `compare` is evaluated for each sample,
  /// including the first sample.
  struct Gate {
    std::vector<Condition> conditions{};  ///< all nodes of the tree; empty: every sample passes
    /// The minimum time between two samples; 0: there is no minimum.
    std::chrono::microseconds least_period{0};

    /// Returns true if every sample is sent.
    bool is_open() const { return conditions.empty() && least_period.count() == 0; }
    friend bool operator==(const Gate&, const Gate&) = default;
  };

  static constexpr std::size_t parts_max = 16;           ///< the maximum number of fields with parts
  static constexpr std::size_t channels_max = 64;        ///< the maximum number of channels in a part
  static constexpr std::size_t channel_bytes_max = 255;  ///< the maximum length of the name of a channel
  static constexpr std::size_t conditions_max = 32;      ///< the maximum number of terms of a gate
  static constexpr std::size_t depth_max = 8;            ///< the maximum nesting of `and` and `or`
  static constexpr std::size_t changed_leaves_max =
      64;                                         ///< the maximum number of leaves in a `changed` condition
  static constexpr std::size_t bytes_max = 2048;  ///< the maximum number of bytes from to_bytes()
  /// The longest period of a condition or a rate.
  static constexpr std::chrono::microseconds period_max{std::chrono::hours(24)};

  /// Makes the empty selection of a type without leaves.
  Selection() = default;
  /// Selects whole fields of every sample.
  Selection(FieldMask mask) : mask_(std::move(mask)) {}  // NOLINT(google-explicit-constructor)

  /// Makes a selection. Adds the leaves of all parts to the mask, and brings everything into canonical
  /// form. The error says which limit is exceeded.
  static Result<Selection> make(FieldMask mask, std::vector<Part> parts, Gate gate);

  /// Returns the fields that are selected, whole or in part.
  const FieldMask& mask() const { return mask_; }
  /// Returns the parts by leaf in ascending order. A leaf that is selected whole has no part.
  std::span<const Part> parts() const;
  /// Returns the part of the leaf; null if the leaf is selected whole, or is not selected.
  const Part* part(std::size_t leaf) const;
  /// Returns the gate, which decides when samples are sent.
  const Gate& gate() const;
  /// Returns true if there are neither parts nor a gate.
  bool is_mask() const { return extra_ == nullptr; }

  /// Returns the same selection with another gate. The error says which limit is exceeded.
  Result<Selection> with_gate(Gate gate) const;
  /// Returns a selection of the same fields and parts without a gate, so that every sample is sent.
  Selection without_gate() const;
  /// Returns the same selection without a maximum rate; the conditions stay.
  Selection without_rate() const;

  /// Returns the selection that one sample must have to serve both selections, which must be of the same
  /// type. The result has all fields of both selections. A leaf that both select has the channels of both,
  /// and it has the rows and columns of the selections if these are the same in both, otherwise all rows
  /// and columns. The result has the gate of the selections if it is the same in both, otherwise no gate.
  /// If the result exceeds a limit, its fields are whole. If it then still exceeds a limit, it has no gate.
  Selection joined(const Selection& other) const;

  friend bool operator==(const Selection& a, const Selection& b);

  /// Returns the hash of fields and parts. For a mask it is FieldMask::hash(). Equal selections have equal
  /// hashes.
  std::uint64_t what_hash() const;
  /// Returns what_hash() if there are parts, and 0 otherwise.
  std::uint64_t parts_hash() const { return parts().empty() ? 0 : what_hash(); }
  /// Returns the hash of the gate; 0 if the gate is open.
  std::uint64_t gate_hash() const;
  /// Returns the hash of the whole selection. Equal selections have equal hashes. For a mask it is
  /// FieldMask::hash().
  std::uint64_t hash() const;

  /// Returns the selection as bytes, at most bytes_max. Equal selections have equal bytes (selection.md,
  /// "Bytes").
  std::vector<std::byte> to_bytes() const;
  /// Reads a selection of a type with this number of leaves. Refuses bytes that to_bytes() would not write.
  static Result<Selection> from_bytes(std::span<const std::byte> bytes, std::size_t leaves);

 private:
  struct Extra {
    std::vector<Part> parts;
    Gate gate;
    std::uint64_t parts_hash = 0;
    std::uint64_t gate_hash = 0;
  };
  FieldMask mask_;
  std::shared_ptr<const Extra> extra_;  ///< parts and gate; null: there are no parts, and the gate is open
};

}  // namespace sft
