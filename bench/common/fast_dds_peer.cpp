// The contender Fast DDS. A sample is held as CDR, which is copied to the wire and from the wire. That
// takes less time than code from Fast DDS's own generator.
#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "bench/common/contender.h"
#include "bench/common/fast_dds.h"
#include "bench/common/message_set.h"

namespace sft::bench {

namespace {

namespace dds = fast::dds;
namespace transports = fast::transports;

struct Ways {
  bool over_udp = true;
  bool in_memory = false;
  bool usual = false;  ///< true: the contender has its default settings
  bool multicast = false;
};

using fast::Body, fast::BodyType;

/// Returns the bodies that are sent in turns. If the sample has a number, the body begins with it.
std::vector<Body> bodies_of(const Topic& topic) {
  if (topic.messages) return topic.messages->bodies();
  constexpr std::size_t small_bytes = 64, number_and_stamp_bytes = 16;
  if (topic.bulk_bytes == 0) return {Body(small_bytes)};
  Body bulk(number_and_stamp_bytes + sizeof topic.bulk_bytes + topic.bulk_bytes, std::byte{1});
  std::memcpy(bulk.data() + number_and_stamp_bytes, &topic.bulk_bytes, sizeof topic.bulk_bytes);
  return {std::move(bulk)};
}

std::size_t largest(const std::vector<Body>& bodies) {
  return std::ranges::max(bodies, {}, &Body::size).size();
}

dds::Topic& topic_of(fast::Participant& participant, const Topic& topic) {
  return participant.topic(topic.name.c_str(),
                           new BodyType("sft_bench::" + topic.name, largest(bodies_of(topic))));
}

/// The transport between hosts. It has the largest datagrams, which IP fragments, and buffers for several
/// samples.
std::shared_ptr<transports::UDPv4TransportDescriptor> udp(const Ways& ways) {
  auto transport = std::make_shared<transports::UDPv4TransportDescriptor>();
  if (ways.usual) return transport;
  transport->maxMessageSize = 65'500;
  transport->sendBufferSize = 4 << 20;
  transport->receiveBufferSize = 16 << 20;
  return transport;
}

/// The transport in shared memory. The segment has room for several of the largest samples. Pieces of a
/// megabyte are the fastest: Fast DDS writes a piece while the reader reads the previous one.
std::shared_ptr<transports::SharedMemTransportDescriptor> shared_memory(const Ways& ways) {
  auto transport = std::make_shared<transports::SharedMemTransportDescriptor>();
  transport->segment_size(ways.usual ? 40'000'000 : 64 << 20);
  if (!ways.usual) transport->max_message_size(1'000'000);
  return transport;
}

std::unique_ptr<fast::Participant> open(const Ways& ways) {
  if (!ways.in_memory) return std::make_unique<fast::Participant>(udp(ways));
  if (!ways.over_udp) return std::make_unique<fast::Participant>(shared_memory(ways));
  return std::make_unique<fast::Participant>(shared_memory(ways), udp(ways));
}

template <class Qos>
Qos qos_of(const Topic& topic, const Ways& ways, Qos qos) {
  qos = fast::best_effort(qos);
  qos.data_sharing().off();
  qos.resource_limits().allocated_samples = 0;  // otherwise Fast DDS reserves memory for a hundred samples
  if (ways.usual) qos.history().depth = static_cast<std::int32_t>(topic.depth);
  if (!topic.reliable) return qos;
  qos.reliability().kind = dds::RELIABLE_RELIABILITY_QOS;
  if (ways.usual) return qos;
  qos.history().kind = dds::KEEP_ALL_HISTORY_QOS;
  qos.resource_limits().max_samples = static_cast<std::int32_t>(topic.depth);
  qos.resource_limits().max_samples_per_instance = static_cast<std::int32_t>(topic.depth);
  qos.resource_limits().max_instances = 1;
  return qos;
}

dds::DataWriterQos writer_qos(const Topic& topic, const Ways& ways) {
  constexpr std::size_t in_one_datagram_bytes = 60'000;
  dds::DataWriterQos qos = qos_of(topic, ways, dds::DATAWRITER_QOS_DEFAULT);
  if (!ways.usual) {
    qos.reliability().max_blocking_time = {10, 0};
    fast::answer_soon(qos);
  }
  // Fast DDS sends samples that exceed a datagram only from a separate thread.
  const bool by_a_thread = ways.over_udp || topic.reliable;
  if (by_a_thread && largest(bodies_of(topic)) > in_one_datagram_bytes)
    qos.publish_mode().kind = dds::ASYNCHRONOUS_PUBLISH_MODE;
  return qos;
}

dds::DataReaderQos reader_qos(const Topic& topic, const Ways& ways) {
  constexpr std::uint16_t group_port = 7900;
  dds::DataReaderQos qos = qos_of(topic, ways, dds::DATAREADER_QOS_DEFAULT);
  if (!ways.usual) fast::ask_at_once(qos);
  if (ways.multicast) {
    fast::rtps::Locator_t group;
    fast::IPLocator::setIPv4(group, 239, 255, 0, 42);
    group.port = group_port;
    qos.endpoint().multicast_locator_list.push_back(group);
  }
  return qos;
}

class FastDdsWriter : public Writer {
 public:
  FastDdsWriter(fast::Participant& participant, const Topic& topic, const Ways& ways)
      : writer_(participant.writer(topic_of(participant, topic), writer_qos(topic, ways))),
        bodies_(bodies_of(topic)),
        numbered_(!topic.messages),
        patient_(!ways.usual) {}

  std::size_t readers() const override { return fast::readers(writer_); }
  void write(std::uint64_t number) override {
    Body& body = bodies_[number % bodies_.size()];
    if (numbered_) std::memcpy(body.data(), &number, sizeof number);
    // A write into a full history can fail without a wait. In that case the next attempt succeeds.
    while (!fast::write(writer_, &body) && patient_) {
    }
  }

 private:
  dds::DataWriter& writer_;
  std::vector<Body> bodies_;
  const bool numbered_;
  const bool patient_;
};

/// A reader that deserializes every sample into the same memory.
class FastDdsReader : public Reader, private dds::DataReaderListener {
 public:
  FastDdsReader(fast::Participant& participant, const Topic& topic, const Ways& ways, Arrived arrived)
      : arrived_(std::move(arrived)),
        reader_(participant.reader(topic_of(participant, topic), reader_qos(topic, ways),
                                   arrived_ ? this : nullptr)) {}
  ~FastDdsReader() override { reader_.set_listener(nullptr); }

  std::size_t writers() const override { return fast::writers(reader_); }
  void wait() override { reader_.wait_for_unread_message({1, 0}); }
  std::uint64_t take() override { return take_from(reader_) ? number() : 0; }

 private:
  void on_data_available(dds::DataReader* reader) override {
    while (take_from(*reader)) arrived_(number());
  }
  bool take_from(dds::DataReader& reader) {
    dds::SampleInfo info;
    while (fast::is_ok(reader.take_next_sample(&body_, &info))) {
      if (info.valid_data) return true;
    }
    return false;
  }
  /// Returns the number of the sample. Must be called only for samples with a number.
  std::uint64_t number() const {
    std::uint64_t number = 0;
    std::memcpy(&number, body_.data(), std::min(sizeof number, body_.size()));
    return number;
  }

  const Arrived arrived_;
  Body body_;
  dds::DataReader& reader_;
};

class FastDdsPeer : public Peer {
 public:
  explicit FastDdsPeer(const Ways& ways) : ways_(ways), participant_(open(ways)) {}

  std::unique_ptr<Writer> writer(const Topic& topic) override {
    return std::make_unique<FastDdsWriter>(*participant_, topic, ways_);
  }
  std::unique_ptr<Reader> reader(const Topic& topic, Arrived arrived) override {
    return std::make_unique<FastDdsReader>(*participant_, topic, ways_, std::move(arrived));
  }

 private:
  const Ways ways_;
  const std::unique_ptr<fast::Participant> participant_;
};

std::unique_ptr<Peer> peer(const Ways& ways) { return std::make_unique<FastDdsPeer>(ways); }

}  // namespace

std::unique_ptr<Peer> fast_dds_peer() { return peer({}); }
std::unique_ptr<Peer> fast_dds_usual_peer() { return peer({.usual = true}); }
std::unique_ptr<Peer> fast_dds_multicast_peer() { return peer({.usual = true, .multicast = true}); }
std::unique_ptr<Peer> fast_dds_local_peer() { return peer({.in_memory = true, .usual = true}); }
std::unique_ptr<Peer> fast_dds_memory_peer() { return peer({.over_udp = false, .in_memory = true}); }

}  // namespace sft::bench
