// The readers, or the writers, of unmodified nodes that a participant has discovered. With them the log can
// name the reason why samples are not exchanged with one of these endpoints: DDS itself reports nothing if
// the names of types differ, and little if policies differ. Subscribers also have DDS readers only if there
// are such writers.
#pragma once

#include <dds/dds.h>

#include <array>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "core/platform/clock.h"
#include "core/sync/mutex.h"
#include "core/vanilla/vanilla_matching.h"

namespace sft::core {

Guid guid_of(const dds_guid_t& guid);
/// Returns the GUID of an entity of this process.
Guid guid_of(dds_entity_t entity);
/// Returns an announced endpoint as a plain value.
VanillaEndpoint described(const dds_builtintopic_endpoint_t& endpoint);
/// Returns "DDS" and the GUID prefix of the participant in hexadecimal. SFT shows nodes by this name.
std::string name_of_participant(const dds_guid_t& participant);
/// Returns true if the user data say that the endpoint is one of SFT. `qos` may be null.
bool is_endpoint_of_sft(const dds_qos_t* qos);

class VanillaEndpoints {
 public:
  static constexpr std::size_t known_max = 4096;
  /// The minimum time between two searches for endpoints that were ignored.
  static constexpr std::chrono::seconds looks_apart{5};

  /// `builtin_topic` is DDS_BUILTIN_TOPIC_DCPSSUBSCRIPTION for readers, and
  /// DDS_BUILTIN_TOPIC_DCPSPUBLICATION for writers. `changed` may be empty. It is called by threads of
  /// Cyclone when changes() has changed, and must return at once. While `at_most` endpoints are known,
  /// further endpoints are ignored.
  VanillaEndpoints(dds_entity_t participant, dds_entity_t builtin_topic, std::function<void()> changed = {},
                   std::size_t at_most = known_max);
  /// Waits until no listener runs any more. Must be called before the participant is deleted.
  ~VanillaEndpoints();
  VanillaEndpoints(const VanillaEndpoints&) = delete;
  VanillaEndpoints& operator=(const VanillaEndpoints&) = delete;

  /// Returns a number that changes whenever an endpoint appears or departs. Any thread may call this.
  std::uint64_t changes() const { return changes_.load(std::memory_order_relaxed); }
  /// Returns the endpoints of this DDS topic. Any thread may call this.
  std::vector<VanillaEndpoint> of(std::string_view topic) const;
  struct OfTopic {
    std::string topic;  ///< the name of the topic in DDS
    VanillaEndpoint endpoint;
  };
  /// Returns all endpoints. Any thread may call this.
  std::vector<OfTopic> all() const;
  /// Returns the ids of the publishers or subscribers of SFT that have a DDS endpoint. Any thread may call
  /// this.
  std::set<EndpointId> of_sft() const;
  /// Returns the ids of those publishers in of_sft() which announce that a reader does not acknowledge
  /// samples. Any thread may call this.
  std::set<EndpointId> unanswered() const;
  /// Searches for endpoints that were ignored, if other endpoints have departed since then. Called by
  /// agents.
  void look_again(Time now);

 private:
  using Key = std::array<unsigned char, 16>;

  dds_entity_t open_reader();
  void take(dds_entity_t builtin);
  bool note(const dds_builtintopic_endpoint_t& endpoint, const dds_sample_info_t& info) SFT_REQUIRES(mutex_);

  const dds_entity_t participant_, builtin_topic_;
  const std::function<void()> changed_;
  const std::size_t at_most_;
  dds_entity_t reader_ = 0;  ///< used by one thread at a time (see `next_look_`)
  std::atomic<std::uint64_t> changes_{0};
  mutable Mutex mutex_;
  std::map<Key, OfTopic> known_ SFT_GUARDED_BY(mutex_);
  struct OfSft {
    EndpointId id = 0;
    bool is_answered = true;
  };
  std::map<Key, OfSft> of_sft_ SFT_GUARDED_BY(mutex_);
  bool has_ignored_ SFT_GUARDED_BY(mutex_) = false;
  /// The time of the next search; Time::max(): a thread is searching
  Time next_look_ SFT_GUARDED_BY(mutex_){};
};

}  // namespace sft::core
