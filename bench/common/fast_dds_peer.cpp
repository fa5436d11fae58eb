#include <string>
#include <vector>

#include "bench/common/contender.h"
#include "bench/common/fast_dds.h"

namespace sft::bench {

namespace {

namespace dds = fast::dds;

struct Small {
  std::uint64_t number = 0;
  std::uint8_t data[56] = {};
};

struct Bulk {
  std::uint64_t number = 0;
  std::uint64_t stamp_ns = 0;
  std::vector<std::uint8_t> data;
};

class BulkType : public fast::Type<Bulk> {
 public:
  /// A participant may have several types, whose names differ, since it makes room for the size of each.
  explicit BulkType(std::uint32_t data_bytes)
      : Type(("sft_bench::Bulk" + std::to_string(data_bytes)).c_str(), fixed_bytes + data_bytes) {}

 protected:
  void encode(const void* data, fast::rtps::SerializedPayload_t& payload) override {
    const auto& bulk = *static_cast<const Bulk*>(data);
    const auto length = static_cast<std::uint32_t>(bulk.data.size());
    encapsulate(payload, fixed_bytes + length);
    std::byte* to = body(payload, payload.length).data();
    std::memcpy(to, &bulk.number, sizeof bulk.number);
    std::memcpy(to + length_at - sizeof bulk.stamp_ns, &bulk.stamp_ns, sizeof bulk.stamp_ns);
    std::memcpy(to + length_at, &length, sizeof length);
    std::memcpy(to + fixed_bytes, bulk.data.data(), length);
  }
  bool decode(fast::rtps::SerializedPayload_t& payload, void* data) override {
    auto& bulk = *static_cast<Bulk*>(data);
    const std::span<const std::byte> from = body(payload, payload.length);
    if (from.size() < fixed_bytes) return false;
    std::memcpy(&bulk.number, from.data(), sizeof bulk.number);
    std::memcpy(&bulk.stamp_ns, from.data() + length_at - sizeof bulk.stamp_ns, sizeof bulk.stamp_ns);
    bulk.data.resize(from.size() - fixed_bytes);
    std::memcpy(bulk.data.data(), from.data() + fixed_bytes, bulk.data.size());
    return true;
  }
  std::uint32_t encoded_bytes(const void* data) override {
    const auto length = static_cast<std::uint32_t>(static_cast<const Bulk*>(data)->data.size());
    return fast::encapsulation_bytes + fixed_bytes + length;
  }

 private:
  static constexpr std::uint32_t length_at = 2 * sizeof(std::uint64_t);
  static constexpr std::uint32_t fixed_bytes = length_at + sizeof(std::uint32_t);
};

fast::AnyType* type_of(const Topic& topic) {
  if (topic.bulk_bytes > 0) return new BulkType(topic.bulk_bytes);
  return new fast::PlainType<Small>("sft_bench::Small");
}

/// The transport between hosts, with the largest datagrams, which IP fragments, and buffers for several
/// samples.
std::shared_ptr<fast::transports::UDPv4TransportDescriptor> udp() {
  auto transport = std::make_shared<fast::transports::UDPv4TransportDescriptor>();
  transport->maxMessageSize = 65'500;
  transport->sendBufferSize = 4 << 20;
  transport->receiveBufferSize = 16 << 20;
  return transport;
}

/// The segment has room for several of the largest samples. Pieces of a megabyte are the fastest: Fast DDS
/// writes a piece while the reader reads the one before.
std::shared_ptr<fast::transports::SharedMemTransportDescriptor> shared_memory() {
  auto transport = std::make_shared<fast::transports::SharedMemTransportDescriptor>();
  transport->segment_size(64 << 20);
  transport->max_message_size(1'000'000);
  return transport;
}

template <class Qos>
Qos qos_of(const Topic& topic, Qos qos) {
  qos = fast::best_effort(qos);
  qos.data_sharing().off();
  if (!topic.reliable) return qos;
  qos.reliability().kind = dds::RELIABLE_RELIABILITY_QOS;
  qos.history().kind = dds::KEEP_ALL_HISTORY_QOS;
  qos.resource_limits().max_samples = static_cast<std::int32_t>(topic.depth);
  qos.resource_limits().max_samples_per_instance = static_cast<std::int32_t>(topic.depth);
  qos.resource_limits().max_instances = 1;
  qos.resource_limits().allocated_samples = 0;
  return qos;
}

// Fast DDS sends larger samples over UDP only from a thread of its own.
constexpr std::uint32_t in_one_datagram_bytes = 60'000;

dds::DataWriterQos writer_qos(const Topic& topic) {
  dds::DataWriterQos qos = qos_of(topic, dds::DATAWRITER_QOS_DEFAULT);
  qos.reliability().max_blocking_time = {10, 0};
  fast::answer_soon(qos);
  if (topic.bulk_bytes > in_one_datagram_bytes) qos.publish_mode().kind = dds::ASYNCHRONOUS_PUBLISH_MODE;
  return qos;
}

dds::DataReaderQos reader_qos(const Topic& topic) {
  dds::DataReaderQos qos = qos_of(topic, dds::DATAREADER_QOS_DEFAULT);
  fast::ask_at_once(qos);
  return qos;
}

template <class T>
class FastDdsWriter : public Writer {
 public:
  FastDdsWriter(fast::Participant& participant, const Topic& topic)
      : writer_(participant.writer(participant.topic(topic.name, type_of(topic)), writer_qos(topic))) {
    if constexpr (requires { message_.data.resize(1); }) message_.data.resize(topic.bulk_bytes, 1);
  }

  std::size_t readers() const override { return fast::readers(writer_); }
  void write(std::uint64_t number) override {
    message_.number = number;
    // A write into a full history can fail without having waited; it then succeeds the next time.
    while (!fast::write(writer_, &message_)) {
    }
  }

 private:
  dds::DataWriter& writer_;
  T message_{};
};

/// Deserializes every sample into the same memory.
template <class T>
class FastDdsReader : public Reader, private dds::DataReaderListener {
 public:
  FastDdsReader(fast::Participant& participant, const Topic& topic, Arrived arrived)
      : arrived_(std::move(arrived)),
        reader_(participant.reader(participant.topic(topic.name, type_of(topic)), reader_qos(topic),
                                   arrived_ ? this : nullptr)) {}
  ~FastDdsReader() override { reader_.set_listener(nullptr); }
  FastDdsReader(const FastDdsReader&) = delete;
  FastDdsReader& operator=(const FastDdsReader&) = delete;

  std::size_t writers() const override { return fast::writers(reader_); }
  void wait() override { reader_.wait_for_unread_message({1, 0}); }
  std::uint64_t take() override { return take_from(reader_); }

 private:
  void on_data_available(dds::DataReader* reader) override {
    while (const std::uint64_t number = take_from(*reader)) arrived_(number);
  }
  std::uint64_t take_from(dds::DataReader& reader) {
    dds::SampleInfo info;
    while (fast::is_ok(reader.take_next_sample(&message_, &info))) {
      if (info.valid_data) return message_.number;
    }
    return 0;
  }

  const Arrived arrived_;
  T message_{};
  dds::DataReader& reader_;
};

class FastDdsPeer : public Peer {
 public:
  template <class Transport>
  explicit FastDdsPeer(Transport transport) : participant_(std::move(transport)) {}

  std::unique_ptr<Writer> writer(const Topic& topic) override {
    if (topic.bulk_bytes > 0) return std::make_unique<FastDdsWriter<Bulk>>(participant_, topic);
    return std::make_unique<FastDdsWriter<Small>>(participant_, topic);
  }
  std::unique_ptr<Reader> reader(const Topic& topic, Arrived arrived) override {
    if (topic.bulk_bytes > 0)
      return std::make_unique<FastDdsReader<Bulk>>(participant_, topic, std::move(arrived));
    return std::make_unique<FastDdsReader<Small>>(participant_, topic, std::move(arrived));
  }

 private:
  fast::Participant participant_;
};

}  // namespace

std::unique_ptr<Peer> fast_dds_peer() { return std::make_unique<FastDdsPeer>(udp()); }
std::unique_ptr<Peer> fast_dds_memory_peer() { return std::make_unique<FastDdsPeer>(shared_memory()); }

}  // namespace sft::bench
