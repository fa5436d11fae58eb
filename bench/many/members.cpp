#include "bench/many/members.h"

#include <algorithm>

#include "bench/common/pair.h"

namespace sft::bench {

namespace {

constexpr const char* topic = "points";
constexpr std::chrono::seconds patience{60};  // many nodes that start at once need time

template <class Status>
bool connected(const Status& status) {
  return std::ranges::any_of(status.writers, &SubscriberStatus::Writer::connected);
}

dds_entity_t cyclone_reader(const CycloneParticipant& participant, dds_on_data_available_fn on_data,
                            void* context) {
  return participant.reader(sensor_msgs_msg_PointCloud2_desc, topic, cyclone_best_effort().get(), on_data,
                            context);
}

}  // namespace

SftMember::Writer::Writer(SftMember& member, std::size_t data_bytes)
    : publisher_(member.node_.publisher<Message>(topic).value()), cloud_(cloud(data_bytes)) {}

bool SftMember::Writer::serves(std::size_t readers) const {
  return publisher_.wait_for_subscribers(readers, std::chrono::nanoseconds(0));
}

SftMember::Reader::Reader(SftMember& member) : subscriber_(member.node_.subscriber<Message>(topic).value()) {}

bool SftMember::Reader::matched() const { return connected(subscriber_.status()); }

SftMember::MaskedReader::MaskedReader(SftMember& member, const std::string& fields,
                                      const std::function<void()>& arrived)
    : subscriber_(
          member.node_
              .subscriber(topic, *member.type_, fields, {}, [arrived](const DynamicSample&) { arrived(); })
              .value()) {}

bool SftMember::MaskedReader::matched() const { return connected(subscriber_.status()); }

void SftMember::know_publisher() { type_ = node_.find_type(topic, patience).value(); }

CycloneMember::Writer::Writer(CycloneMember& member, std::size_t data_bytes)
    : writer_(
          member.participant_.writer(sensor_msgs_msg_PointCloud2_desc, topic, cyclone_best_effort().get())),
      cloud_(data_bytes) {}

CycloneMember::Reader::Reader(CycloneMember& member)
    : reader_(cyclone_reader(member.participant_, nullptr, nullptr)) {}

CycloneMember::MaskedReader::MaskedReader(CycloneMember& member, const std::string&,
                                          std::function<void()> arrived)
    : arrived_(std::move(arrived)), reader_(cyclone_reader(member.participant_, take_all, this)) {}

void CycloneMember::MaskedReader::take_all(dds_entity_t reader, void* self) {
  auto& that = *static_cast<MaskedReader*>(self);
  void* sample = &that.message_;
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
