// Decides whether a writer and a reader of one topic match, and by which paths samples can go between them,
// as one of their nodes sees it. All functions are pure.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "core/control/control.h"
#include "core/negotiation/type_comparisons.h"
#include "sft/status.h"

namespace sft::core {

/// What has to be known of this node to decide about paths.
struct Self {
  HostToken host{};  ///< known while shared memory is ready
  std::uint64_t network = 0;
  std::string memory_state{};    ///< why shared memory is not ready, as a text for people
  std::string memory_failure{};  ///< why the last attempt failed, for other nodes; kept until one succeeds
  bool may_write_memory = true;  ///< this process may write to the shared memory, if there is any
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
  std::string mismatch;  ///< why the pair never matches; empty: it matches
  bool incompatible_type = false;
  std::shared_ptr<const TypeMismatch>
      definitions;  ///< not null: the two have different definitions of a type
  QosPolicy incompatible_policy = QosPolicy::none;
  bool memory = false;  ///< both may and can use shared memory
  bool network = false;
  std::string network_reason;
  bool memory_may_come = false;  ///< there is no path, but shared memory may still become available
};

/// `type` is the type of our endpoint, or of the writer if both are ours. Without `comparisons` different
/// definitions of a type are detected, but not compared.
Verdict evaluate(const Pair& pair, const TypeSupport& type, const Self& self, TypeComparisons* comparisons);

/// Returns how the reader is connected to the writer, according to its request in force. `history_comes`: the
/// retained samples come first, over UDP.
SubscriberStatus::Writer heard_as(const Endpoint& writer, bool writer_lives, const Endpoint& reader,
                                  const Verdict& verdict, bool history_comes);

}  // namespace sft::core
