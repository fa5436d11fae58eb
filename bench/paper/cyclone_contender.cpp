// Cyclone DDS with types that its own compiler made. Apart from multicast it has its default settings.
#include <fields.h>
#include <nav_msgs/msg/OccupancyGrid.h>
#include <sensor_msgs/msg/BatteryState.h>
#include <sensor_msgs/msg/LaserScan.h>
#include <sensor_msgs/msg/PointCloud2.h>

#include <algorithm>
#include <cstdlib>
#include <utility>
#include <vector>

#include "bench/common/cyclone.h"
#include "bench/paper/contender.h"
#include "bench/paper/messages.h"
#include "tests/support/cyclone_cdr.h"

namespace sft::bench::paper {

namespace {

/// Finds the type by its name, which is the same for all middleware.
const dds_topic_descriptor_t& type_of(const Messages& messages) {
  static const dds_topic_descriptor_t* const types[] = {
      &sft_bench_paper_Five128_desc,    &sft_bench_paper_Five256_desc,      &sft_bench_paper_Five512_desc,
      &sft_bench_paper_Seven128_desc,   &sft_bench_paper_Seven256_desc,     &sft_bench_paper_Seven512_desc,
      &sensor_msgs_msg_LaserScan_desc,  &sensor_msgs_msg_BatteryState_desc, &nav_msgs_msg_OccupancyGrid_desc,
      &sensor_msgs_msg_PointCloud2_desc};
  const auto found = std::ranges::find_if(
      types, [&](const auto* type) { return messages.type().name() == type->m_typename; });
  if (found == std::end(types)) std::abort();
  return **found;
}

CycloneQos qos_of(const Contender& contender) {
  CycloneQos qos = cyclone_best_effort();
  if (contender.reliable) {
    dds_qset_reliability(qos.get(), DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
    dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, depth);
  }
  return qos;
}

class CycloneWriter : public Writer {
 public:
  CycloneWriter(const CycloneParticipant& participant, const std::string& topic, const Messages& messages,
                const dds_qos_t* qos)
      : writer_(participant.writer(type_of(messages), topic.c_str(), qos)) {
    for (const auto& body : messages.bodies()) {
      readers_.push_back(std::make_unique<test::CycloneReader>(type_of(messages)));
      messages_.push_back(readers_.back()->deserialize(body));
      if (messages_.back() == nullptr) std::abort();
    }
  }

  bool serves(std::size_t readers) const override { return CycloneParticipant::readers(writer_) == readers; }
  void write(std::size_t number) override { dds_write(writer_, messages_[number]); }

 private:
  const dds_entity_t writer_;
  std::vector<std::unique_ptr<test::CycloneReader>> readers_;  ///< own the messages
  std::vector<const void*> messages_;
};

/// Takes every message into the same memory.
class CycloneReader : public Reader {
 public:
  CycloneReader(const CycloneParticipant& participant, const std::string& topic, const Messages& messages,
                const dds_qos_t* qos, Arrived arrived)
      : arrived_(std::move(arrived)),
        type_(type_of(messages)),
        message_(dds_alloc(type_.m_size)),
        reader_(participant.reader(type_, topic.c_str(), qos, take_all, this)) {}
  ~CycloneReader() override {
    dds_delete(reader_);  // ends its callbacks before the members are destroyed
    dds_sample_free(message_, &type_, DDS_FREE_ALL);
  }
  CycloneReader(const CycloneReader&) = delete;
  CycloneReader& operator=(const CycloneReader&) = delete;

  bool matched() const override { return CycloneParticipant::writers(reader_) == 1; }

 private:
  static void take_all(dds_entity_t reader, void* self) {
    auto& that = *static_cast<CycloneReader*>(self);
    dds_sample_info_t info;
    while (dds_take(reader, &that.message_, &info, 1, 1) == 1) {
      if (info.valid_data) that.arrived_();
    }
  }

  const Arrived arrived_;
  const dds_topic_descriptor_t& type_;
  void* message_;
  const dds_entity_t reader_;
};

class CyclonePeer : public Peer {
 public:
  explicit CyclonePeer(const Contender& contender)
      : participant_(contender.multicast ? "" : unicast), qos_(qos_of(contender)) {}

  std::unique_ptr<Writer> writer(const std::string& topic, const Messages& messages) override {
    return std::make_unique<CycloneWriter>(participant_, topic, messages, qos_.get());
  }
  std::unique_ptr<Reader> reader(const std::string& topic, const Messages& messages, FieldSet,
                                 Arrived arrived) override {
    return std::make_unique<CycloneReader>(participant_, topic, messages, qos_.get(), std::move(arrived));
  }

 private:
  static constexpr const char* unicast = "<General><AllowMulticast>spdp</AllowMulticast></General>";

  const CycloneParticipant participant_;
  const CycloneQos qos_;
};

}  // namespace

std::unique_ptr<Peer> open_cyclone(const Contender& contender) {
  return std::make_unique<CyclonePeer>(contender);
}

}  // namespace sft::bench::paper
