#include "bench/many/members.h"

#include <algorithm>

#include "bench/common/cyclone_point_cloud.h"
#include "bench/common/pair.h"

namespace sft::bench {

namespace {

constexpr const char* topic = "points";
constexpr std::chrono::seconds patience{60};  // many nodes that start at once need time

template <class Status>
bool connected(const Status& status) {
  return std::ranges::any_of(status.writers, &SubscriberStatus::Writer::connected);
}

Reliability reliability_of(const Payload& payload) {
  return payload.reliable ? Reliability::reliable : Reliability::best_effort;
}

CycloneQos qos_of(const Payload& payload) {
  CycloneQos qos = cyclone_best_effort();
  if (payload.reliable) dds_qset_reliability(qos.get(), DDS_RELIABILITY_RELIABLE, DDS_INFINITY);
  return qos;
}

}  // namespace

SftMember::Writer::Writer(SftMember& member, const Payload& payload)
    : sender_(payload.sft(
          member.node_, topic,
          {.reliability = reliability_of(payload), .max_sample_bytes = payload.sample_bytes_max})) {}

SftMember::Reader::Reader(SftMember& member) : subscriber_(member.node_.subscriber<Message>(topic).value()) {}

bool SftMember::Reader::matched() const { return connected(subscriber_.status()); }

void SftMember::MaskedReader::ask_for(const std::string& fields) {
  subscriber_.reset();
  subscriber_ = member_.node_
                    .subscriber(topic, *member_.type_, fields, {.reliability = reliability_of(payload_)},
                                [this](const DynamicSample&) { arrived_(); })
                    .value();
}

bool SftMember::MaskedReader::matched() const { return connected(subscriber_->status()); }

void SftMember::know_publisher() { type_ = node_.find_type(topic, patience).value(); }

CycloneMember::Writer::Writer(CycloneMember& member, const Payload& payload)
    : writer_(member.participant_.writer(*payload.cyclone_type, topic, qos_of(payload).get())),
      message_(payload.cyclone()) {}

CycloneMember::Reader::Reader(CycloneMember& member)
    : reader_(member.participant_.reader(sensor_msgs_msg_PointCloud2_desc, topic, cyclone_best_effort().get(),
                                         nullptr, nullptr)) {}

CycloneMember::MaskedReader::MaskedReader(CycloneMember& member, const Payload& payload,
                                          std::function<void()> arrived)
    : arrived_(std::move(arrived)),
      message_(payload.cyclone_type->m_size / sizeof(std::uint64_t) + 1),
      reader_(
          member.participant_.reader(*payload.cyclone_type, topic, qos_of(payload).get(), take_all, this)) {}

void CycloneMember::MaskedReader::take_all(dds_entity_t reader, void* self) {
  auto& that = *static_cast<MaskedReader*>(self);
  void* sample = that.message_.data();
  dds_sample_info_t info;
  while (dds_take(reader, &sample, &info, 1, 1) == 1) {
    if (info.valid_data) that.arrived_();
  }
}

/// Looks for the announcement of the writer.
void CycloneMember::know_publisher() {
  const dds_entity_t announcements =
      checked(dds_create_reader(participant_.entity(), DDS_BUILTIN_TOPIC_DCPSPUBLICATION, nullptr, nullptr));
  const auto announced = [&] {
    void* sample = nullptr;
    dds_sample_info_t info;
    const dds_return_t count = dds_take(announcements, &sample, &info, 1, 1);
    if (count > 0) dds_return_loan(announcements, &sample, count);
    return count > 0;
  };
  wait_until(announced, static_cast<double>(patience.count()));
  dds_delete(announcements);
}

}  // namespace sft::bench
