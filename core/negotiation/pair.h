// Decides whether a writer and a reader of one topic match, and by which paths samples can be sent between
// them, according to what one of their two nodes knows. All functions are pure.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "core/control/control.h"
#include "core/negotiation/type_comparisons.h"
#include "sft/status.h"

namespace sft::core {

/// The facts about this node that the choice of paths depends on.
struct Self {
  HostToken host{};  ///< known only while shared memory is ready
  std::uint64_t network = 0;
  std::string memory_state{};    ///< why shared memory is not ready, as a text for people
  std::string memory_failure{};  ///< why the last attempt to use shared memory has failed, for other nodes;
                                 ///< kept until an attempt succeeds
  bool may_write_memory = true;  ///< this process may write to the shared memory of the host
  friend bool operator==(const Self&, const Self&) = default;
};

/// A writer and a reader of one topic. At least one of them is ours.
struct Pair {
  const Endpoint& writer;
  const Endpoint& reader;
  bool we_write = false;  ///< true: the writer is ours; false: only the reader is
  const Endpoint& peer() const { return we_write ? reader : writer; }
};

struct Verdict {
  std::string mismatch;  ///< why the pair never matches; empty: the pair matches
  bool incompatible_type = false;
  std::shared_ptr<const TypeMismatch>
      definitions;  ///< not null: the writer and the reader have different definitions of a type
  QosPolicy incompatible_policy = QosPolicy::none;
  bool memory = false;  ///< both endpoints may use shared memory, and can
  bool network = false;
  std::string network_reason;
  bool memory_may_come = false;  ///< there is no path yet, but shared memory may still become available
};

/// Decides about the pair. `type` is the type of our endpoint, or of the writer if both endpoints are ours.
/// If `comparisons` is null, the result only says that the definitions of a type differ, and not how.
Verdict evaluate(const Pair& pair, const TypeSupport& type, const Self& self, TypeComparisons* comparisons);

/// Returns how the reader is connected to the writer, according to the reader's request that is in force.
/// `history_comes`: the reader first gets the retained samples, over UDP.
SubscriberStatus::Writer heard_as(const Endpoint& writer, bool writer_lives, const Endpoint& reader,
                                  const Verdict& verdict, bool history_comes);

}  // namespace sft::core
