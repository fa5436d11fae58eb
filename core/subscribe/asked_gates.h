// Keeps the gates with conditions that a reader has asked its writers for, one after the other, and says
// which of them can have been in force between two samples. Uses no clock, thread or I/O.
//
// A new request takes effect with a delay, and samples come under earlier requests meanwhile. If no sample
// comes under a request, only this record shows that it may have been in force. Samples that it has withheld
// must not count as lost. Samples that come over the network do not show which request is in force, because a
// sample for another reader of the process may suit this reader, too.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace sft::core {

/// Gates are named by gate_id(); 0 is the one without conditions.
class AskedGates {
 public:
  /// The number of a request. Only requests for another gate or rate limit than the previous one are counted.
  using Number = std::uint64_t;

  /// Called when the reader asks for that gate. The first call is treated as if the reader had always asked
  /// for it. `is_limited`: there is a maximum rate.
  void ask(std::uint64_t gate, bool is_limited = false);
  Number latest() const { return end() - 1; }
  /// Called when no sample that was sent under requests before `request` is under way or waits in a queue any
  /// more.
  void settle(Number request);

  /// Returns the earliest request that can be in force for samples that come from now on.
  Number settled() const { return settled_; }
  /// Returns the earliest request from `since` on that can be in force for a sample in shared memory that
  /// names no gate: the first one without conditions. Returns `since` if there is none, or if samples need
  /// not name one of the gates in between.
  Number open_since(Number since) const;
  /// Returns the only gate with conditions of the requests from `first` on; 0 if none has conditions. Returns
  /// nothing if there are several, if a request without conditions but with a maximum rate can have withheld
  /// samples that pass the gate, or if not all of these requests are known any more.
  std::optional<std::uint64_t> only_gate_since(Number first) const;
  /// Returns true if the requests from `first` on ask for all samples: none has conditions or a maximum rate.
  /// Returns false if not all of them are known any more.
  bool asks_for_all_since(Number first) const;
  /// Returns the gates with conditions that samples in shared memory may name, the latest first.
  std::span<const std::uint64_t> nameable() const { return nameable_; }

 private:
  static constexpr std::size_t kept_max = 64;
  static constexpr std::size_t nameable_max = 8;  ///< the table of each sample is searched for each of them

  struct Request {
    std::uint64_t gate = 0;
    bool is_limited = false;
    friend bool operator==(const Request&, const Request&) = default;
  };

  Number end() const { return oldest_ + requests_.size(); }
  const Request& at(Number request) const { return requests_[request - oldest_]; }

  std::vector<Request> requests_{Request{}};  ///< the requests from `oldest_` on; neighbours differ
  Number oldest_ = 0;
  Number settled_ = 0;
  bool was_asked_ = false;
  std::vector<std::uint64_t> nameable_;
};

}  // namespace sft::core
