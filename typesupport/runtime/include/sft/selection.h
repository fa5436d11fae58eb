// A selection: which fields of a message a subscriber needs, which part of each, and when. selection.md has
// the text form, with all rules.
//
// A selection without parts and without a gate is a field mask, and costs what one costs: copies of it share
// nothing, and comparing two of them compares their masks. Everything beyond that is in one immutable object,
// which copies share. A selection is made for one message type, and means nothing for another one. Any thread
// may read a selection; what is said of a FieldMask holds for changes.
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

/// Fields of a message type, whole or in part, and when samples are sent.
class Selection {
 public:
  /// Every step-th index of [begin, end). The canonical form has begin = end = 0 and step = 1 for an empty
  /// range, step = 1 for a single index, and the least `end` that keeps the same indices.
  struct Range {
    /// An end that is no index.
    static constexpr std::uint32_t no_end = (std::numeric_limits<std::uint32_t>::max)();

    std::uint32_t begin = 0;     ///< the first index
    std::uint32_t end = no_end;  ///< no_end: as many as there are
    std::uint32_t step = 1;      ///< at least 1

    /// True if every index is kept.
    bool is_all() const { return begin == 0 && end == no_end && step == 1; }
    /// True if no index is kept.
    bool is_empty() const { return begin >= end; }
    /// How many of `count` indices are kept.
    std::uint32_t size_of(std::uint32_t count) const;
    /// The range of the former's result, in indices of the whole: a part of a part. Empty if an index of it
    /// would be too large.
    Range then(const Range& inner) const;
    /// The canonical form of the same indices.
    Range canonical() const;
    friend bool operator==(const Range&, const Range&) = default;
  };

  /// The part of one leaf, which is an array or a sequence and in no other sequence.
  struct Part {
    std::uint32_t leaf = 0;  ///< the number of the leaf
    Range rows{};            ///< all, where the leaf has no rows
    Range columns{};         ///< elements, where the leaf has no rows
    /// Names, ascending, each once; empty: all. A name is printable UTF-8 without ',', '}' and outer blanks.
    std::vector<std::string> channels{};
    /// A hash of the layout rule that the type is annotated with, which gives rows, columns and channels
    /// their meaning. 0: the type has none. parse_selection() and TypeSupport::closed() enter it.
    std::uint32_t rule = 0;

    /// True if it is the whole leaf.
    bool is_whole() const { return rows.is_all() && columns.is_all() && channels.empty(); }
    friend bool operator==(const Part&, const Part&) = default;
  };

  /// A number in a condition. In the canonical form a whole number is an integer if one can hold it, and it
  /// is signed only if it is negative.
  using Number = std::variant<std::int64_t, std::uint64_t, double>;

  /// A condition, or several with a word between: nodes of a tree, each before its children.
  struct Condition {
    /// Which of the members count, and how.
    enum class Kind : std::uint8_t {
      all_of,   ///< all children hold
      any_of,   ///< at least one child holds
      compare,  ///< a scalar leaf with a number
      changed,  ///< a leaf differs from what it was in the last sample that passed
      nth,      ///< every n-th sample
      elapsed   ///< none has passed for so long
    };
    /// How the field is to the number.
    enum class Comparison : std::uint8_t { less, less_or_equal, greater, greater_or_equal, equal, not_equal };

    Kind kind{};              ///< what it is
    Comparison comparison{};  ///< the comparison of a `compare` condition
    bool is_percent = false;  ///< of changed: the deadband is a part of the former value; not if it is 0
    std::vector<std::uint32_t> leaves{};  ///< compare: one; changed: ascending, each once
    std::uint32_t children = 0;           ///< of all_of and any_of: at least two
    Number number{std::uint64_t{0}};  ///< of compare; changed: the deadband; nth: n; elapsed: microseconds
    friend bool operator==(const Condition&, const Condition&) = default;
  };

  /// When a sample is sent. What has changed is told from the last sample that passed, as for ON_CHANGE in
  /// gNMI, whose heartbeat is `elapsed` here. A deadband is that of OPC UA part 4, section 7.22.2, but a
  /// deadband in percent is of the former value. After a request `changed`, `nth` and `elapsed` hold until a
  /// sample has passed; `compare` asks about each sample, also the first one.
  struct Gate {
    std::vector<Condition> conditions{};        ///< empty: every sample
    std::chrono::microseconds least_period{0};  ///< between two samples; 0: as often as they are published

    /// True if every sample is sent.
    bool is_open() const { return conditions.empty() && least_period.count() == 0; }
    friend bool operator==(const Gate&, const Gate&) = default;
  };

  static constexpr std::size_t parts_max = 16;           ///< fields with parts
  static constexpr std::size_t channels_max = 64;        ///< of a part
  static constexpr std::size_t channel_bytes_max = 255;  ///< of a name
  static constexpr std::size_t conditions_max = 32;      ///< with the nodes between them
  static constexpr std::size_t depth_max = 8;            ///< the maximum nesting of `and` and `or`
  static constexpr std::size_t changed_leaves_max = 64;  ///< of a condition
  static constexpr std::size_t bytes_max = 2048;         ///< of to_bytes()
  /// The longest period of a condition or a rate.
  static constexpr std::chrono::microseconds period_max{std::chrono::hours(24)};

  /// Nothing of a type without leaves.
  Selection() = default;
  /// The whole fields of the mask, of every sample.
  Selection(FieldMask mask) : mask_(std::move(mask)) {}  // NOLINT(google-explicit-constructor)

  /// The leaves of all parts are added to the mask, and all is brought into its canonical form. The error
  /// says which limit is exceeded.
  static Result<Selection> make(FieldMask mask, std::vector<Part> parts, Gate gate);

  /// The fields, whole or in part.
  const FieldMask& mask() const { return mask_; }
  /// By leaf, ascending; a whole leaf has none.
  std::span<const Part> parts() const;
  /// Null: the whole leaf, or nothing of it.
  const Part* part(std::size_t leaf) const;
  /// When samples are sent.
  const Gate& gate() const;
  /// True if there are neither parts nor a gate.
  bool is_mask() const { return extra_ == nullptr; }

  /// The same with another gate. The error says which limit is exceeded.
  Result<Selection> with_gate(Gate gate) const;
  /// The same fields and parts of every sample.
  Selection without_gate() const;
  /// The same without a maximum rate; the conditions stay.
  Selection without_rate() const;

  /// What one sample must have to serve both: all fields of both; of a leaf that both ask for, the part of
  /// both if these have the same rows and columns, and all rows and columns otherwise; the channels of both.
  /// The gate of both if they have the same, and none otherwise. Both are of the same type. Where that
  /// exceeds a limit, the fields are whole; if it still does, there is no gate.
  Selection joined(const Selection& other) const;

  friend bool operator==(const Selection& a, const Selection& b);

  /// Of fields and parts; of a mask it is FieldMask::hash(). Equal selections have equal hashes.
  std::uint64_t what_hash() const;
  /// The same if there are parts, and 0 otherwise.
  std::uint64_t parts_hash() const { return parts().empty() ? 0 : what_hash(); }
  /// Of the gate; 0: it is open.
  std::uint64_t gate_hash() const;
  /// The hash of all of it. Equal selections have equal hashes; that of a mask is FieldMask::hash().
  std::uint64_t hash() const;

  /// At most bytes_max. Equal selections have equal bytes (selection.md, "Bytes").
  std::vector<std::byte> to_bytes() const;
  /// Of a type with so many leaves. Refuses what to_bytes() would not write.
  static Result<Selection> from_bytes(std::span<const std::byte> bytes, std::size_t leaves);

 private:
  struct Extra {
    std::vector<Part> parts;
    Gate gate;
    std::uint64_t parts_hash = 0;
    std::uint64_t gate_hash = 0;
  };
  FieldMask mask_;
  std::shared_ptr<const Extra> extra_;  ///< null: no parts, and the gate is open
};

}  // namespace sft
