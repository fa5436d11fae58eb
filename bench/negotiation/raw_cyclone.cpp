#include "bench/negotiation/raw_cyclone.h"

#include "core/discovery/dds_config.h"
#include "sft_control.h"

namespace sft::bench {

namespace {

CycloneQos qos_of(RawCyclone::Delivery delivery) {
  CycloneQos qos = cyclone_best_effort();
  if (delivery == RawCyclone::Delivery::last_value) {
    dds_qset_reliability(qos.get(), DDS_RELIABILITY_RELIABLE, DDS_MSECS(100));
    dds_qset_durability(qos.get(), DDS_DURABILITY_TRANSIENT_LOCAL);
  }
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

RawCyclone::RawCyclone() : participant_(core::dds_config(0, {}, "").value().text.c_str()) {}

dds_entity_t RawCyclone::writer(const std::string& name, Delivery delivery) {
  return participant_.writer(sft_control_Request_desc, name.c_str(), qos_of(delivery).get());
}

dds_entity_t RawCyclone::reader(const std::string& name, Delivery delivery, const Arrived& arrived) {
  return participant_.reader(sft_control_Request_desc, name.c_str(), qos_of(delivery).get(), on_data,
                             const_cast<Arrived*>(&arrived));
}

void RawCyclone::write(dds_entity_t writer, std::uint64_t number) {
  sft_control_Request request{};
  request.reader = 1;
  request.request_sequence = number;
  dds_write(writer, &request);
}

}  // namespace sft::bench
