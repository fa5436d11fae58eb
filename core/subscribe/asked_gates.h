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

/// A gate is named as by gate_id(); 0 is the one without conditions, which every sample passes.
class AskedGates {
 public:
  /// Counts the changes from one gate to another.
  using Number = std::uint64_t;

  /// The reader asks for that gate from now on. What it asks for first has always been so.
  void ask(std::uint64_t gate);
  /// Nothing that was sent under earlier requests is under way any more.
  void settle();

  /// The earliest request that can be in force for what comes from now on.
  Number settled() const { return settled_; }
  /// The first request without conditions from `since` on; `since` if there is none.
  Number open_since(Number since) const;
  /// The only gate with conditions of the requests from that one on; 0 if none has conditions. Nothing if
  /// there are several, or if not all of them are known any more.
  std::optional<std::uint64_t> only_gate_since(Number first) const;
  /// The gates with conditions that samples in shared memory may name: the latest is the first.
  std::span<const std::uint64_t> nameable() const { return nameable_; }

 private:
  static constexpr std::size_t kept_max = 64;
  static constexpr std::size_t nameable_max = 8;  ///< samples under earlier ones are not in a queue any more

  Number end() const { return oldest_ + gates_.size(); }
  std::uint64_t gate_of(Number request) const { return gates_[request - oldest_]; }

  std::vector<std::uint64_t> gates_{0};  ///< of the requests from `oldest_` on; neighbours differ
  Number oldest_ = 0;
  Number settled_ = 0;
  bool was_asked_ = false;
  std::vector<std::uint64_t> nameable_;
};

}  // namespace sft::core
