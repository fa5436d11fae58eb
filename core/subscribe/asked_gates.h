// The gates with conditions that a reader has asked its writers for, one after the other: which of them can
// have been in force between two samples. Pure.
//
// A request takes its time. Samples come under earlier requests meanwhile, and a request under which nothing
// comes is known by nothing but its own record. What it has withheld must not count as lost. Samples that
// come over the network do not tell which request is in force, since those for another reader of the process
// may suit this one as well.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace sft::core {

/// A gate is named as by gate_id(); 0 is the one without conditions.
class AskedGates {
 public:
  /// Counts the requests for another gate than before, or for another limit.
  using Number = std::uint64_t;

  /// The reader asks for that gate from now on. What it asks for first has always been so. `is_limited`: by a
  /// maximum rate.
  void ask(std::uint64_t gate, bool is_limited = false);
  Number latest() const { return end() - 1; }
  /// Nothing that was sent under requests before that one is under way, or waits in a queue, any more.
  void settle(Number request);

  /// The earliest request that can be in force for what comes from now on.
  Number settled() const { return settled_; }
  /// The request that can be in force for a sample in shared memory that names no gate, if none before
  /// `since` can: the first one without conditions. `since` if there is none, or if samples need not name one
  /// of the gates in between.
  Number open_since(Number since) const;
  /// The only gate with conditions of the requests from that one on; 0 if none has conditions. Nothing if
  /// there are several, or others can have withheld what has passed it, or not all are known any more.
  std::optional<std::uint64_t> only_gate_since(Number first) const;
  /// True if the requests from that one on ask for all samples: none has conditions, and none a maximum rate.
  /// False if not all of them are known any more.
  bool asks_for_all_since(Number first) const;
  /// The gates with conditions that samples in shared memory may name: the latest is the first.
  std::span<const std::uint64_t> nameable() const { return nameable_; }

 private:
  static constexpr std::size_t kept_max = 64;
  static constexpr std::size_t nameable_max = 8;  ///< each sample is searched for each of them

  struct Request {
    std::uint64_t gate = 0;
    bool is_limited = false;
    friend bool operator==(const Request&, const Request&) = default;
  };

  Number end() const { return oldest_ + requests_.size(); }
  const Request& at(Number request) const { return requests_[request - oldest_]; }

  std::vector<Request> requests_{Request{}};  ///< from `oldest_` on; neighbours differ
  Number oldest_ = 0;
  Number settled_ = 0;
  bool was_asked_ = false;
  std::vector<std::uint64_t> nameable_;
};

}  // namespace sft::core
