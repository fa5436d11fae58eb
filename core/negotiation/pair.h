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

/// This node, as far as it decides about paths.
struct Self {
  HostToken host{};  ///< known while shared memory is ready
  std::uint64_t network = 0;
  std::string memory_state{};    ///< why shared memory is not ready, for reasons given to people
  std::string memory_failure{};  ///< the same for other nodes: of the last failed attempt, until one works
  bool may_write_memory = true;  ///< where it is
  friend bool operator==(const Self&, const Self&) = default;
};

/// One of them is ours, or both.
struct Pair {
  const Endpoint& writer;
  const Endpoint& reader;
  bool we_write = false;  ///< or only read
  const Endpoint& peer() const { return we_write ? reader : writer; }
};

struct Verdict {
  std::string mismatch;  ///< not empty: never matches, and why
  bool incompatible_type = false;
  std::shared_ptr<const TypeMismatch> definitions;  ///< not null: they are two of one type
  QosPolicy incompatible_policy = QosPolicy::none;
  bool memory = false;  ///< both may and can use shared memory
  bool network = false;
  std::string network_reason;
  bool memory_may_come = false;  ///< neither, as yet
};

/// `type`: of what is ours; of the writer if both are. Without `comparisons` two definitions of a type are
/// told apart, and not compared.
Verdict evaluate(const Pair& pair, const TypeSupport& type, const Self& self, TypeComparisons* comparisons);

/// Returns how the reader hears the writer, as its request in force tells. With `history_comes` the samples
/// that were published before come first, over UDP.
SubscriberStatus::Writer heard_as(const Endpoint& writer, bool writer_lives, const Endpoint& reader,
                                  const Verdict& verdict, bool history_comes);

}  // namespace sft::core
