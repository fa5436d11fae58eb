// The readers, or the writers, of unmodified nodes that a participant has discovered. They are kept so that
// the log can say why one of them is not served or heard: DDS itself reports nothing if the names of types
// differ, and little if policies do. Writers are also the reason why subscribers have DDS readers.
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
  /// The least time between two looks for endpoints that were ignored.
  static constexpr std::chrono::seconds looks_apart{5};

  /// `builtin_topic`: DDS_BUILTIN_TOPIC_DCPSSUBSCRIPTION for readers, or DDS_BUILTIN_TOPIC_DCPSPUBLICATION
  /// for writers. `changed`, if given, is called by threads of Cyclone when changes() has changed; it must
  /// return at once. While `at_most` endpoints are known, further ones are ignored.
  VanillaEndpoints(dds_entity_t participant, dds_entity_t builtin_topic, std::function<void()> changed = {},
                   std::size_t at_most = known_max);
  /// Waits until no listener runs any more. Must be called before the participant is deleted.
  ~VanillaEndpoints();
  VanillaEndpoints(const VanillaEndpoints&) = delete;
  VanillaEndpoints& operator=(const VanillaEndpoints&) = delete;

  /// Returns a number that changes whenever an endpoint comes or goes. Any thread.
  std::uint64_t changes() const { return changes_.load(std::memory_order_relaxed); }
  /// Returns the endpoints of that DDS topic. Any thread.
  std::vector<VanillaEndpoint> of(std::string_view topic) const;
  struct OfTopic {
    std::string topic;  ///< its name in DDS
    VanillaEndpoint endpoint;
  };
  /// Returns all endpoints. Any thread.
  std::vector<OfTopic> all() const;
  /// Returns the ids of the publishers or subscribers of SFT that have such an endpoint. Any thread.
  std::set<EndpointId> of_sft() const;
  /// Returns those of them that say that some reader does not acknowledge what it is sent. Any thread.
  std::set<EndpointId> unanswered() const;
  /// Looks for the endpoints that were ignored if others have gone since then. Called by agents.
  void look_again(Time now);

 private:
  using Key = std::array<unsigned char, 16>;

  dds_entity_t open_reader();
  void take(dds_entity_t builtin);
  bool note(const dds_builtintopic_endpoint_t& endpoint, const dds_sample_info_t& info) SFT_REQUIRES(mutex_);

  const dds_entity_t participant_, builtin_topic_;
  const std::function<void()> changed_;
  const std::size_t at_most_;
  dds_entity_t reader_ = 0;  ///< used by one thread at a time: see `next_look_`
  std::atomic<std::uint64_t> changes_{0};
  mutable Mutex mutex_;
  std::map<Key, OfTopic> known_ SFT_GUARDED_BY(mutex_);
  struct OfSft {
    EndpointId id = 0;
    bool is_answered = true;
  };
  std::map<Key, OfSft> of_sft_ SFT_GUARDED_BY(mutex_);
  bool has_ignored_ SFT_GUARDED_BY(mutex_) = false;
  Time next_look_ SFT_GUARDED_BY(mutex_){};  ///< Time::max(): a thread looks
};

}  // namespace sft::core
