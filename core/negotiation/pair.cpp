#include "core/negotiation/pair.h"

#include <utility>

#include "core/platform/network_id.h"

namespace sft::core {

namespace {

std::string why_not_memory(const Pair& pair, const Self& self) {
  if (!pair.writer.may_use_memory) return "the publisher or its node rules shared memory out";
  if (!pair.reader.may_use_memory) return "the subscriber or its node rules shared memory out";
  const Endpoint& peer = pair.peer();
  if (!on_one_machine(peer.network, self.network)) return "another host";
  if (self.host.known() && peer.host.known() && peer.host != self.host)
    return "another host or container: it has a /dev/shm of its own";
  if (!self.host.known()) return "no shared memory: " + self.memory_state;
  if (pair.we_write && !self.may_write_memory && peer.host.known())
    return "this user may only read shared memory";
  if (peer.memory_failure.empty()) return "the other side has no shared memory yet";
  return "the other side has no shared memory: " + peer.memory_failure;
}

/// Returns true if a pair on one machine may share memory later. This is possible even if the host tokens
/// differ, since one token may be that of a daemon that has just ended.
bool may_come_to_share(const Pair& pair, const Self& self) {
  const bool read_only = pair.we_write && self.host.known() && !self.may_write_memory;
  return pair.writer.may_use_memory && pair.reader.may_use_memory &&
         on_one_machine(pair.peer().network, self.network) && !read_only;
}

void compare_types(const Pair& pair, const TypeSupport& type, TypeComparisons* comparisons,
                   Verdict& verdict) {
  const auto& [writer, reader, we_write] = pair;
  if (writer.type_name != reader.type_name) {
    verdict.mismatch =
        "type " + writer.type_name + " is published, " + reader.type_name + " is subscribed to";
  } else if (writer.type_hash != reader.type_hash) {
    std::string difference;
    if (comparisons != nullptr) {
      verdict.definitions = comparisons->compare(type, pair.peer());
      difference = verdict.definitions->difference;
    }
    verdict.mismatch = "two different definitions of type " + writer.type_name +
                       (difference.empty() ? "" : ": " + difference);
  }
  verdict.incompatible_type = !verdict.mismatch.empty();
}

}  // namespace

Verdict evaluate(const Pair& pair, const TypeSupport& type, const Self& self, TypeComparisons* comparisons) {
  const auto& [writer, reader, we_write] = pair;
  Verdict verdict;
  compare_types(pair, type, comparisons, verdict);
  if (verdict.incompatible_type) return verdict;
  if (QosConflict conflict = conflict_between(writer.qos, reader.qos); conflict.policy != QosPolicy::none) {
    verdict.incompatible_policy = conflict.policy;
    verdict.mismatch = std::move(conflict.reason);
    return verdict;
  }
  verdict.memory = writer.may_use_memory && reader.may_use_memory && self.host.known() &&
                   writer.host == self.host && reader.host == self.host;
  verdict.network = writer.may_use_network && reader.may_use_network && !reader.addresses.empty();
  if (!verdict.memory) verdict.network_reason = why_not_memory(pair, self);
  verdict.memory_may_come = !verdict.memory && !verdict.network && may_come_to_share(pair, self);
  return verdict;
}

SubscriberStatus::Writer heard_as(const Endpoint& writer, bool writer_lives, const Endpoint& reader,
                                  const Verdict& verdict, bool history_comes) {
  const bool attached = verdict.memory && holds(reader.request.attached, writer.id);
  const bool listening = verdict.network && holds(reader.request.listening, writer.id);
  SubscriberStatus::Writer status{.id = writer.id, .node = writer.node, .alive = writer_lives};
  status.incompatible_type = verdict.incompatible_type;
  status.incompatible_policy = verdict.incompatible_policy;
  status.matched = verdict.memory || verdict.network;
  status.connected = writer_lives && (attached || listening);
  status.no_path = !status.matched && verdict.mismatch.empty();
  status.no_path_yet = verdict.memory_may_come;
  status.transport = attached || !verdict.network ? TransportKind::shm : TransportKind::udp;
  status.mismatch = verdict.definitions;
  status.reason = !verdict.mismatch.empty()         ? verdict.mismatch
                  : !writer_lives                   ? "its node does not answer"
                  : attached                        ? "same host"
                  : verdict.memory && history_comes ? "same host; retained samples come first, by UDP"
                  : verdict.memory                  ? "same host, shared memory is being attached"
                  : verdict.network                 ? verdict.network_reason
                                                    : "UDP is ruled out, and " + verdict.network_reason;
  return status;
}

}  // namespace sft::core
