// Fast DDS: shared memory within the host, UDP to the other one.
#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "bench/common/fast_dds_point_cloud.h"
#include "bench/isolation/contender.h"

namespace sft::bench::isolation {

namespace {

namespace dds = fast::dds;
namespace transports = fast::transports;
using Message = fast::PointCloudType::Message;

/// Room for several messages. The default is less than a tenth of one, with which none arrives.
constexpr std::uint32_t segment_bytes = 40'000'000;

std::shared_ptr<transports::UDPv4TransportDescriptor> udp() {
  return std::make_shared<transports::UDPv4TransportDescriptor>();
}

std::shared_ptr<transports::SharedMemTransportDescriptor> shared_memory() {
  auto transport = std::make_shared<transports::SharedMemTransportDescriptor>();
  transport->segment_size(segment_bytes);
  return transport;
}

template <class Qos>
Qos qos_of(bool reliable, Qos qos) {
  qos = fast::best_effort(qos);
  qos.data_sharing().off();
  qos.history().depth = depth;
  if (reliable) qos.reliability().kind = dds::RELIABLE_RELIABILITY_QOS;
  return qos;
}

dds::Topic& topic_of(fast::Participant& participant, const char* topic) {
  const std::string type = std::string("PointCloud2_of_") + topic;
  return participant.topic(topic, new fast::PointCloudType(type.c_str()));
}

class FastDdsWriter : public Writer {
 public:
  explicit FastDdsWriter(bool reliable) {
    dds::DataWriterQos qos = qos_of(reliable, dds::DATAWRITER_QOS_DEFAULT);
    qos.publish_mode().kind = dds::ASYNCHRONOUS_PUBLISH_MODE;  // only so are large messages sent in pieces
    for (const char* topic : topics)
      writers_.push_back(&participant_.writer(topic_of(participant_, topic), qos));
  }

  bool serves(std::size_t readers) const override {
    return std::ranges::all_of(
        writers_, [&](const dds::DataWriter* writer) { return fast::readers(*writer) == readers; });
  }
  void write(std::uint64_t number) override {
    cloud_.width = static_cast<std::uint32_t>(number);
    fast::write(*writers_[number % topics.size()], &cloud_);
  }

 private:
  fast::Participant participant_{shared_memory(), udp()};
  std::vector<dds::DataWriter*> writers_;
  Message cloud_ = cloud(sent_cloud_bytes);
};

/// Takes each message of one topic into the same memory.
class TopicReader : private dds::DataReaderListener {
 public:
  TopicReader(fast::Participant& participant, const char* topic, bool reliable, Arrived arrived)
      : arrived_(std::move(arrived)),
        reader_(participant.reader(topic_of(participant, topic),
                                   qos_of(reliable, dds::DATAREADER_QOS_DEFAULT), this)) {}
  ~TopicReader() override { reader_.set_listener(nullptr); }
  TopicReader(const TopicReader&) = delete;
  TopicReader& operator=(const TopicReader&) = delete;

  bool is_matched() const { return fast::writers(reader_) == 1; }

 private:
  void on_data_available(dds::DataReader* reader) override {
    dds::SampleInfo info;
    while (fast::is_ok(reader->take_next_sample(&cloud_, &info))) {
      if (info.valid_data && cloud_.data.size() == sent_cloud_bytes) arrived_(cloud_.width);
    }
  }

  const Arrived arrived_;
  Message cloud_;
  dds::DataReader& reader_;
};

class FastDdsReader : public Reader {
 public:
  FastDdsReader(std::unique_ptr<fast::Participant> participant, bool reliable, const Arrived& arrived)
      : participant_(std::move(participant)) {
    for (const char* topic : topics)
      readers_.push_back(std::make_unique<TopicReader>(*participant_, topic, reliable, arrived));
  }

  bool is_matched() const override {
    return std::ranges::all_of(readers_, [](const auto& reader) { return reader->is_matched(); });
  }

 private:
  const std::unique_ptr<fast::Participant> participant_;
  std::vector<std::unique_ptr<TopicReader>> readers_;
};

}  // namespace

std::unique_ptr<Writer> open_fast_dds_writer(bool reliable) {
  return std::make_unique<FastDdsWriter>(reliable);
}

std::unique_ptr<Reader> open_fast_dds_reader(bool reliable, Place place, Arrived arrived) {
  auto participant = place == Place::local ? std::make_unique<fast::Participant>(shared_memory(), udp())
                                           : std::make_unique<fast::Participant>(udp());
  return std::make_unique<FastDdsReader>(std::move(participant), reliable, arrived);
}

}  // namespace sft::bench::isolation
