#include "tests/negotiation/forger.h"

#include <algorithm>
#include <stdexcept>
#include <string>

namespace sft::test {

namespace {

dds_entity_t checked(dds_entity_t entity) {
  if (entity < 0) throw std::runtime_error(std::string("forger: ") + dds_strretcode(entity));
  return entity;
}

template <class Sample, class Use>
void take_all(dds_entity_t reader, Use use) {
  for (;;) {
    void* sample = nullptr;
    dds_sample_info_t info;
    if (dds_take(reader, &sample, &info, 1, 1) <= 0) return;
    if (info.valid_data) use(*static_cast<const Sample*>(sample));
    dds_return_loan(reader, &sample, 1);
  }
}

}  // namespace

Forger::Forger() : participant_(checked(dds_create_participant(0, nullptr, nullptr))) {
  dds_qos_t* const qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_MSECS(100));
  dds_qset_durability(qos, DDS_DURABILITY_TRANSIENT_LOCAL);
  dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 1);
  dds_qset_writer_data_lifecycle(qos, false);
  dds_qset_ignorelocal(qos, DDS_IGNORELOCAL_PARTICIPANT);
  const auto topic = [&](const dds_topic_descriptor_t& type, const char* name) {
    return checked(dds_create_topic(participant_, &type, name, qos, nullptr));
  };
  const dds_entity_t endpoint = topic(sft_control_Endpoint_desc, "sft_endpoint");
  const dds_entity_t request = topic(sft_control_Request_desc, "sft_request");
  endpoints_ = checked(dds_create_reader(participant_, endpoint, qos, nullptr));
  requests_ = checked(dds_create_reader(participant_, request, qos, nullptr));
  endpoint_writer_ = checked(dds_create_writer(participant_, endpoint, qos, nullptr));
  request_writer_ = checked(dds_create_writer(participant_, request, qos, nullptr));
  dds_delete_qos(qos);
}

void Forger::look() {
  const auto note = [this](std::uint64_t id, std::uint64_t sequence) {
    known_[id] = std::max(known_[id], sequence);
  };
  take_all<sft_control_Endpoint>(endpoints_, [&](const sft_control_Endpoint& endpoint) {
    note(endpoint.id, endpoint.role == 1 ? endpoint.request.request_sequence : 0);
  });
  take_all<sft_control_Request>(
      requests_, [&](const sft_control_Request& request) { note(request.reader, request.request_sequence); });
}

void Forger::withdraw_all() {
  look();
  for (const auto& [id, sequence] : known_) {
    sft_control_Endpoint key{};
    key.id = id;
    checked(dds_dispose(endpoint_writer_, &key));
  }
}

void Forger::mute_all(std::uint64_t ahead) {
  look();
  for (const auto& [id, sequence] : known_) {
    if (sequence == 0) continue;
    sft_control_Request request{};
    request.reader = id;
    request.version = sft_control_protocol_version;
    request.request_sequence = sequence + ahead;
    checked(dds_write(request_writer_, &request));
  }
}

}  // namespace sft::test
