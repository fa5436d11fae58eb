#include "bench/negotiation/raw_cyclone.h"

#include <cstdio>
#include <cstdlib>
#include <memory>

#include "core/dds_config.h"
#include "sft_control.h"

namespace sft::bench {

namespace {

dds_entity_t checked(dds_entity_t entity) {
  if (entity >= 0) return entity;
  std::fprintf(stderr, "Cyclone DDS: %s\n", dds_strretcode(entity));
  std::exit(1);
}

using Qos = std::unique_ptr<dds_qos_t, void (*)(dds_qos_t*)>;

Qos qos_of(RawCyclone::Delivery delivery) {
  Qos qos(dds_create_qos(), dds_delete_qos);
  if (delivery == RawCyclone::Delivery::last_value) {
    dds_qset_reliability(qos.get(), DDS_RELIABILITY_RELIABLE, DDS_MSECS(100));
    dds_qset_durability(qos.get(), DDS_DURABILITY_TRANSIENT_LOCAL);
  } else {
    dds_qset_reliability(qos.get(), DDS_RELIABILITY_BEST_EFFORT, 0);
  }
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, 1);
  return qos;
}

void on_data(dds_entity_t reader, void* arrived) {
  void* sample = nullptr;
  dds_sample_info_t info;
  while (dds_take(reader, &sample, &info, 1, 1) == 1) {
    if (info.valid_data) {
      const auto& request = *static_cast<const sft_control_Request*>(sample);
      (*static_cast<const RawCyclone::Arrived*>(arrived))(request.request_sequence);
    }
    dds_return_loan(reader, &sample, 1);
    sample = nullptr;
  }
}

}  // namespace

RawCyclone::RawCyclone()
    : domain_(checked(dds_create_domain(0, core::dds_config(0, {}, "").value().text.c_str()))),
      participant_(checked(dds_create_participant(0, nullptr, nullptr))) {}

RawCyclone::~RawCyclone() { dds_delete(domain_); }

dds_entity_t RawCyclone::topic(const std::string& name) {
  const dds_entity_t known =
      dds_find_topic(DDS_FIND_SCOPE_PARTICIPANT, participant_, name.c_str(), nullptr, 0);
  if (known > 0) return known;
  return checked(dds_create_topic(participant_, &sft_control_Request_desc, name.c_str(), nullptr, nullptr));
}

dds_entity_t RawCyclone::writer(const std::string& name, Delivery delivery) {
  return checked(dds_create_writer(participant_, topic(name), qos_of(delivery).get(), nullptr));
}

dds_entity_t RawCyclone::reader(const std::string& name, Delivery delivery, const Arrived& arrived) {
  dds_listener_t* listener = dds_create_listener(const_cast<Arrived*>(&arrived));
  dds_lset_data_available(listener, on_data);
  const dds_entity_t reader =
      checked(dds_create_reader(participant_, topic(name), qos_of(delivery).get(), listener));
  dds_delete_listener(listener);
  return reader;
}

void RawCyclone::write(dds_entity_t writer, std::uint64_t number) {
  sft_control_Request request{};
  request.reader = 1;
  request.request_sequence = number;
  dds_write(writer, &request);
}

std::size_t RawCyclone::readers(dds_entity_t writer) {
  dds_publication_matched_status_t status{};
  dds_get_publication_matched_status(writer, &status);
  return status.current_count;
}

}  // namespace sft::bench
