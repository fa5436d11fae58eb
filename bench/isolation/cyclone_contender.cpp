// Cyclone DDS with its default settings: UDP, within the host, too.
#include <algorithm>
#include <utility>
#include <vector>

#include "bench/common/cyclone.h"
#include "bench/common/cyclone_point_cloud.h"
#include "bench/isolation/contender.h"

namespace sft::bench::isolation {

namespace {

constexpr const char* default_settings = "";
const dds_topic_descriptor_t& type = sensor_msgs_msg_PointCloud2_desc;

CycloneQos qos(bool reliable) {
  CycloneQos qos = cyclone_best_effort();
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, depth);
  if (reliable) dds_qset_reliability(qos.get(), DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
  return qos;
}

class CycloneWriter : public Writer {
 public:
  explicit CycloneWriter(bool reliable) {
    for (const char* topic : topics)
      writers_.push_back(participant_.writer(type, topic, qos(reliable).get()));
  }

  bool serves(std::size_t readers) const override {
    return std::ranges::all_of(
        writers_, [&](dds_entity_t writer) { return CycloneParticipant::readers(writer) == readers; });
  }
  void write(std::uint64_t number) override {
    cloud_.message().width = static_cast<std::uint32_t>(number);
    dds_write(writers_[number % topics.size()], &cloud_.message());
  }

 private:
  const CycloneParticipant participant_{default_settings};
  std::vector<dds_entity_t> writers_;
  CyclonePointCloud cloud_{sent_cloud_bytes};
};

/// Takes each message of one topic into the same memory.
class TopicReader {
 public:
  TopicReader(const CycloneParticipant& participant, const char* topic, bool reliable, Arrived arrived)
      : arrived_(std::move(arrived)),
        reader_(participant.reader(type, topic, qos(reliable).get(), take_all, this)) {}
  ~TopicReader() {
    dds_delete(reader_);  // ends its callbacks before the members are destroyed
    dds_sample_free(message_, &type, DDS_FREE_ALL);
  }
  TopicReader(const TopicReader&) = delete;
  TopicReader& operator=(const TopicReader&) = delete;

  bool is_matched() const { return CycloneParticipant::writers(reader_) == 1; }

 private:
  static void take_all(dds_entity_t reader, void* self) {
    auto& that = *static_cast<TopicReader*>(self);
    dds_sample_info_t info;
    while (dds_take(reader, &that.message_, &info, 1, 1) == 1) {
      const auto& cloud = *static_cast<const sensor_msgs_msg_PointCloud2*>(that.message_);
      if (info.valid_data && cloud.data._length == sent_cloud_bytes) that.arrived_(cloud.width);
    }
  }

  const Arrived arrived_;
  void* message_ = dds_alloc(type.m_size);
  const dds_entity_t reader_;
};

class CycloneReader : public Reader {
 public:
  CycloneReader(bool reliable, const Arrived& arrived) {
    for (const char* topic : topics)
      readers_.push_back(std::make_unique<TopicReader>(participant_, topic, reliable, arrived));
  }

  bool is_matched() const override {
    return std::ranges::all_of(readers_, [](const auto& reader) { return reader->is_matched(); });
  }

 private:
  const CycloneParticipant participant_{default_settings};
  std::vector<std::unique_ptr<TopicReader>> readers_;
};

}  // namespace

std::unique_ptr<Writer> open_cyclone_writer(bool reliable) {
  return std::make_unique<CycloneWriter>(reliable);
}

std::unique_ptr<Reader> open_cyclone_reader(bool reliable, Arrived arrived) {
  return std::make_unique<CycloneReader>(reliable, arrived);
}

}  // namespace sft::bench::isolation
