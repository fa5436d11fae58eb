// Records the gates with conditions that a reader has requested from its writers, one after the other, and
// determines which of them can have been in force between two samples. Uses no clock, thread or I/O.
//
// A new request takes effect with a delay. Meanwhile samples arrive for earlier requests. If no sample
// arrives for a request, only this record shows that the request may have been in force. Samples that the
// request has withheld must not count as lost. Samples that arrive over the network do not show which request
// is in force, because a sample for another reader of the process may suit this reader, too.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace sft::core {

/// The record of one reader. Gates are named by gate_id(); 0 is the gate without conditions.
class AskedGates {
 public:
  /// The number of a request. A request counts only if its gate or rate limit differs from the previous one.
  using Number = std::uint64_t;

  /// Called when the reader requests a gate. The first call is treated as if the reader had always requested
  /// that gate. `is_limited` means that there is a maximum rate.
  void ask(std::uint64_t gate, bool is_limited = false);
  Number latest() const { return end() - 1; }
  /// Called when no sample of requests before `request` is under way, or waits in a queue, any more.
  void settle(Number request);

  /// Returns the earliest request that can be in force for samples that arrive from now on.
  Number settled() const { return settled_; }
  /// Returns the earliest request from `since` on that can be in force for a sample in shared memory that
  /// names no gate: the first request without conditions. Returns `since` if there is none, or if one of the
  /// gates in between is not always named by samples.
  Number open_since(Number since) const;
  /// Returns the only gate with conditions of the requests from `first` on, or 0 if none of them has
  /// conditions. Returns nothing in three cases: there are several gates; a request with a maximum rate but
  /// without conditions can have withheld samples that pass the gate; or some of these requests are not
  /// recorded any more.
  std::optional<std::uint64_t> only_gate_since(Number first) const;
  /// Returns true if the requests from `first` on ask for all samples, without conditions or a maximum rate.
  /// Returns false if some of these requests are not recorded any more.
  bool asks_for_all_since(Number first) const;
  /// Returns the gates with conditions that samples in shared memory may name. The latest gate comes first.
  std::span<const std::uint64_t> nameable() const { return nameable_; }

 private:
  static constexpr std::size_t kept_max = 64;
  /// The limit of nameable(): the table of each sample is searched for each of these gates.
  static constexpr std::size_t nameable_max = 8;

  struct Request {
    std::uint64_t gate = 0;
    bool is_limited = false;
    friend bool operator==(const Request&, const Request&) = default;
  };

  Number end() const { return oldest_ + requests_.size(); }
  const Request& at(Number request) const { return requests_[request - oldest_]; }

  /// The requests from `oldest_` on; each differs from the previous one.
  std::vector<Request> requests_{Request{}};
  Number oldest_ = 0;
  Number settled_ = 0;
  bool was_asked_ = false;
  std::vector<std::uint64_t> nameable_;
};

}  // namespace sft::core
