// Cyclone DDS, used as in a program without SFT.
#pragma once

#include <dds/dds.h>

#include <cstddef>
#include <map>
#include <memory>
#include <string>

namespace sft::bench {

/// Ends the program with a message if Cyclone DDS returned an error.
dds_entity_t checked(dds_entity_t entity);

using CycloneQos = std::unique_ptr<dds_qos_t, void (*)(dds_qos_t*)>;
/// Returns QoS with best effort, volatile, and keep last 1.
CycloneQos cyclone_best_effort();

/// One participant in domain 0. Only one thread may call its functions.
class CycloneParticipant {
 public:
  /// Also creates the domain, unless this process already has it. The participant that created the domain
  /// deletes it. REQUIRES: that participant outlives all others.
  explicit CycloneParticipant(const std::string& config);
  ~CycloneParticipant();
  CycloneParticipant(const CycloneParticipant&) = delete;
  CycloneParticipant& operator=(const CycloneParticipant&) = delete;

  dds_entity_t writer(const dds_topic_descriptor_t& type, const std::string& topic,
                      const dds_qos_t* qos) const;
  /// Creates a reader. `on_data`, which may be null, is called with `context` when samples have arrived.
  dds_entity_t reader(const dds_topic_descriptor_t& type, const std::string& topic, const dds_qos_t* qos,
                      dds_on_data_available_fn on_data, void* context) const;

  /// Return the number of readers that are matched with `writer`, and the number of writers that are
  /// matched with `reader`.
  static std::size_t readers(dds_entity_t writer);
  static std::size_t writers(dds_entity_t reader);

  dds_entity_t entity() const { return participant_; }

 private:
  dds_entity_t topic(const dds_topic_descriptor_t& type, const std::string& name) const;

  const dds_entity_t domain_;  ///< the domain; negative: the domain belongs to another participant
  const dds_entity_t participant_;
  mutable std::map<std::string, dds_entity_t> topics_;  ///< topics by name, since dds_find_topic() can crash
};

}  // namespace sft::bench
