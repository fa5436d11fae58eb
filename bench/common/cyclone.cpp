#include "bench/common/cyclone.h"

#include <cstdio>
#include <cstdlib>

namespace sft::bench {

dds_entity_t checked(dds_entity_t entity) {
  if (entity >= 0) return entity;
  std::fprintf(stderr, "Cyclone DDS: %s\n", dds_strretcode(entity));
  std::exit(1);
}

CycloneQos cyclone_best_effort() {
  CycloneQos qos(dds_create_qos(), dds_delete_qos);
  dds_qset_reliability(qos.get(), DDS_RELIABILITY_BEST_EFFORT, 0);
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, 1);
  return qos;
}

namespace {

/// Creates the domain 0. Returns DDS_RETCODE_PRECONDITION_NOT_MET if this process already has that domain.
dds_entity_t create_domain(const std::string& config) {
  const dds_entity_t domain = dds_create_domain(0, config.c_str());
  return domain == DDS_RETCODE_PRECONDITION_NOT_MET ? domain : checked(domain);
}

}  // namespace

CycloneParticipant::CycloneParticipant(const std::string& config)
    : domain_(create_domain(config)), participant_(checked(dds_create_participant(0, nullptr, nullptr))) {}

CycloneParticipant::~CycloneParticipant() { dds_delete(domain_ >= 0 ? domain_ : participant_); }

dds_entity_t CycloneParticipant::topic(const dds_topic_descriptor_t& type, const std::string& name) const {
  const auto [known, is_new] = topics_.try_emplace(name, 0);
  if (is_new) known->second = checked(dds_create_topic(participant_, &type, name.c_str(), nullptr, nullptr));
  return known->second;
}

dds_entity_t CycloneParticipant::writer(const dds_topic_descriptor_t& type, const std::string& name,
                                        const dds_qos_t* qos) const {
  return checked(dds_create_writer(participant_, topic(type, name), qos, nullptr));
}

dds_entity_t CycloneParticipant::reader(const dds_topic_descriptor_t& type, const std::string& name,
                                        const dds_qos_t* qos, dds_on_data_available_fn on_data,
                                        void* context) const {
  dds_listener_t* listener = dds_create_listener(context);
  if (on_data != nullptr) dds_lset_data_available(listener, on_data);
  const dds_entity_t reader = checked(dds_create_reader(participant_, topic(type, name), qos, listener));
  dds_delete_listener(listener);
  return reader;
}

std::size_t CycloneParticipant::readers(dds_entity_t writer) {
  dds_publication_matched_status_t status{};
  dds_get_publication_matched_status(writer, &status);
  return status.current_count;
}

std::size_t CycloneParticipant::writers(dds_entity_t reader) {
  dds_subscription_matched_status_t status{};
  dds_get_subscription_matched_status(reader, &status);
  return status.current_count;
}

}  // namespace sft::bench
