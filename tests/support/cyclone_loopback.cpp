#include "tests/support/cyclone_loopback.h"

#include <dds/ddsi/ddsi_serdata.h>

#include <cstring>
#include <random>

#include "sft/detail/sample_format.h"

namespace sft::test {

namespace {

using namespace detail;

constexpr const char* config =
    "<Domain><General><Interfaces><NetworkInterface name=\"lo\" multicast=\"false\"/></Interfaces>"
    "<AllowMulticast>false</AllowMulticast></General>"
    "<Discovery><ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>99</"
    "MaxAutoParticipantIndex>"
    "</Discovery></Domain>";

constexpr std::size_t padding_to_4(std::size_t bytes) { return (4 - bytes % 4) % 4; }

}  // namespace

CycloneLoopback::CycloneLoopback(const dds_topic_descriptor_t& type) {
  std::random_device random;
  const dds_domainid_t id = 1 + random() % 200;
  domain_ = checked(dds_create_domain(id, config), "domain");
  if (!ok()) return;
  const dds_entity_t participant = checked(dds_create_participant(id, nullptr, nullptr), "participant");
  if (!ok()) return;
  const std::string name = "loopback_" + std::to_string(random());
  const dds_entity_t topic =
      checked(dds_create_topic(participant, &type, name.c_str(), nullptr, nullptr), "topic");
  reader_ = checked(dds_create_reader(participant, topic, nullptr, nullptr), "reader");
  writer_ = checked(dds_create_writer(participant, topic, nullptr, nullptr), "writer");
  if (!ok()) return;
  const std::vector<std::uint64_t> zeros(type.m_size / 8 + 1);
  prototype_ = written(zeros.data());
  if (prototype_ == nullptr) error_ = "a sample did not reach the reader";
}

CycloneLoopback::~CycloneLoopback() {
  if (prototype_ != nullptr) ddsi_serdata_unref(prototype_);
  if (domain_ > 0) dds_delete(domain_);
}

dds_entity_t CycloneLoopback::checked(dds_entity_t entity, const char* what) {
  if (entity < 0 && ok()) error_ = std::string(what) + ": " + dds_strretcode(entity);
  return entity;
}

ddsi_serdata* CycloneLoopback::written(const void* c_struct) {
  ddsi_serdata* data = nullptr;
  dds_sample_info_t info;
  if (dds_write(writer_, c_struct) != DDS_RETCODE_OK) return nullptr;
  return dds_takecdr(reader_, &data, 1, &info, DDS_ANY_STATE) == 1 ? data : nullptr;
}

CyclonePayload CycloneLoopback::sent(const void* c_struct) {
  CyclonePayload payload;
  ddsi_serdata* data = written(c_struct);
  if (data == nullptr) return payload;
  std::vector<std::byte> bytes(ddsi_serdata_size(data));
  ddsi_serdata_to_ser(data, 0, bytes.size(), bytes.data());
  ddsi_serdata_unref(data);

  std::memcpy(payload.encapsulation.data(), bytes.data(), payload.encapsulation.size());
  const std::size_t padding = payload.encapsulation[3] & 3;
  payload.encapsulation[3] &= 0xfc;
  payload.body.assign(bytes.begin() + encapsulation_bytes,
                      bytes.end() - static_cast<std::ptrdiff_t>(padding));
  return payload;
}

bool CycloneLoopback::receive(std::span<const std::byte> body,
                              const std::function<void(const void*)>& visit) {
  std::vector<std::byte> bytes(encapsulation_bytes + body.size() + padding_to_4(body.size()));
  std::memcpy(bytes.data(), encapsulation_cdr_le.data(), encapsulation_bytes);
  bytes[3] = static_cast<std::byte>(padding_to_4(body.size()));
  if (!body.empty()) std::memcpy(bytes.data() + encapsulation_bytes, body.data(), body.size());
  const ddsrt_iovec_t run{bytes.data(), bytes.size()};
  ddsi_serdata* data = ddsi_serdata_from_ser_iov(prototype_->type, SDK_DATA, 1, &run, bytes.size());
  if (data == nullptr || dds_writecdr(writer_, data) != DDS_RETCODE_OK) return false;

  void* sample = nullptr;
  dds_sample_info_t info;
  if (dds_take(reader_, &sample, &info, 1, 1) != 1) return false;
  if (info.valid_data) visit(sample);
  dds_return_loan(reader_, &sample, 1);
  return info.valid_data;
}

}  // namespace sft::test
