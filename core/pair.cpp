#include "core/pair.h"

#include <utility>

#include "core/network_id.h"

namespace sft::core {

namespace {

std::string why_not_shm(const Pair& pair, const Self& self) {
  if (!pair.writer.may_use_shm) return "the publisher or its node rules shared memory out";
  if (!pair.reader.may_use_shm) return "the subscriber or its node rules shared memory out";
  const Endpoint& peer = pair.peer();
  if (!on_one_machine(peer.network, self.network)) return "another host";
  if (self.host.known() && peer.host.known() && peer.host != self.host)
    return "another host or container: it has a /dev/shm of its own";
  if (!self.host.known()) return "no shared memory: " + self.shm_state;
  if (pair.we_write && !self.may_write_shm && peer.host.known())
    return "this user may only read shared memory";
  return "the other side has no shared memory yet; its status says why";
}

/// Of a pair on one machine, where tokens that differ may be those of a daemon that has just gone.
bool may_come_to_share(const Pair& pair, const Self& self) {
  const bool read_only = pair.we_write && self.host.known() && !self.may_write_shm;
  return pair.writer.may_use_shm && pair.reader.may_use_shm &&
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

Verdict judge(const Pair& pair, const TypeSupport& type, const Self& self, TypeComparisons* comparisons) {
  const auto& [writer, reader, we_write] = pair;
  Verdict verdict;
  compare_types(pair, type, comparisons, verdict);
  if (verdict.incompatible_type) return verdict;
  if (QosConflict conflict = conflict_between(writer.qos, reader.qos); conflict.policy != QosPolicy::none) {
    verdict.incompatible_policy = conflict.policy;
    verdict.mismatch = std::move(conflict.reason);
    return verdict;
  }
  verdict.shm = writer.may_use_shm && reader.may_use_shm && self.host.known() && writer.host == self.host &&
                reader.host == self.host;
  verdict.udp = writer.may_use_udp && reader.may_use_udp && !reader.addresses.empty();
  if (!verdict.shm) verdict.udp_reason = why_not_shm(pair, self);
  verdict.shm_may_come = !verdict.shm && !verdict.udp && may_come_to_share(pair, self);
  return verdict;
}

}  // namespace sft::core
