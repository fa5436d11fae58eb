// Fast DDS. A message is its CDR, which is copied to the wire and from it: that takes less time than the code
// that Fast DDS's own generator would write. Apart from multicast it has its default settings.
#include <algorithm>
#include <utility>
#include <vector>

#include "bench/common/fast_dds.h"
#include "bench/paper/contender.h"
#include "bench/paper/messages.h"

namespace sft::bench::paper {

namespace {

namespace dds = fast::dds;

using Body = std::vector<std::byte>;

/// Larger messages are sent in pieces, which only the thread of Fast DDS does.
constexpr std::size_t synchronous_bytes_max = 60'000;

std::size_t largest(const Messages& messages) {
  return std::ranges::max(messages.bodies(), {}, &Body::size).size();
}

class BodyType : public fast::Type<Body> {
 public:
  /// The types of two topics have different names, since their messages may have different sizes.
  BodyType(const std::string& topic, const Messages& messages)
      : Type((std::string(messages.type().name()) + "_" + topic).c_str(),
             static_cast<std::uint32_t>(largest(messages))) {}

 protected:
  void encode(const void* data, fast::rtps::SerializedPayload_t& payload) override {
    const auto& from = *static_cast<const Body*>(data);
    encapsulate(payload, from.size());
    std::memcpy(body(payload, payload.length).data(), from.data(), from.size());
  }
  bool decode(fast::rtps::SerializedPayload_t& payload, void* data) override {
    const std::span<const std::byte> from = body(payload, payload.length);
    static_cast<Body*>(data)->assign(from.begin(), from.end());
    return true;
  }
  std::uint32_t encoded_bytes(const void* data) override {
    return fast::encapsulation_bytes + static_cast<std::uint32_t>(static_cast<const Body*>(data)->size());
  }
};

template <class Qos>
Qos qos_of(const Contender& contender, Qos qos) {
  qos = fast::best_effort(qos);
  qos.data_sharing().off();
  if (contender.reliable) {
    qos.reliability().kind = dds::RELIABLE_RELIABILITY_QOS;
    qos.history().depth = depth;
  }
  return qos;
}

dds::DataReaderQos reader_qos(const Contender& contender) {
  constexpr std::uint16_t port = 7900;
  dds::DataReaderQos qos = qos_of(contender, dds::DATAREADER_QOS_DEFAULT);
  if (contender.multicast) {
    fast::rtps::Locator_t group;
    fast::IPLocator::setIPv4(group, 239, 255, 0, 42);
    group.port = port;
    qos.endpoint().multicast_locator_list.push_back(group);
  }
  return qos;
}

class FastDdsWriter : public Writer {
 public:
  FastDdsWriter(fast::Participant& participant, const std::string& topic, const Messages& messages,
                const Contender& contender)
      : writer_(participant.writer(participant.topic(topic.c_str(), new BodyType(topic, messages)),
                                   qos(contender, messages))),
        bodies_(messages.bodies()) {}

  bool serves(std::size_t readers) const override { return fast::readers(writer_) == readers; }
  void write(std::size_t number) override { fast::write(writer_, &bodies_[number]); }

 private:
  static dds::DataWriterQos qos(const Contender& contender, const Messages& messages) {
    dds::DataWriterQos qos = qos_of(contender, dds::DATAWRITER_QOS_DEFAULT);
    if (largest(messages) > synchronous_bytes_max) qos.publish_mode().kind = dds::ASYNCHRONOUS_PUBLISH_MODE;
    return qos;
  }

  dds::DataWriter& writer_;
  std::vector<Body> bodies_;
};

/// Takes every message into the same memory.
class FastDdsReader : public Reader, private dds::DataReaderListener {
 public:
  FastDdsReader(fast::Participant& participant, const std::string& topic, const Messages& messages,
                const Contender& contender, Arrived arrived)
      : arrived_(std::move(arrived)),
        reader_(participant.reader(participant.topic(topic.c_str(), new BodyType(topic, messages)),
                                   reader_qos(contender), this)) {}
  ~FastDdsReader() override { reader_.set_listener(nullptr); }
  FastDdsReader(const FastDdsReader&) = delete;
  FastDdsReader& operator=(const FastDdsReader&) = delete;

  bool matched() const override { return fast::writers(reader_) == 1; }

 private:
  void on_data_available(dds::DataReader* reader) override {
    dds::SampleInfo info;
    while (fast::is_ok(reader->take_next_sample(&message_, &info))) {
      if (info.valid_data) arrived_();
    }
  }

  const Arrived arrived_;
  Body message_;
  dds::DataReader& reader_;
};

class FastDdsPeer : public Peer {
 public:
  explicit FastDdsPeer(const Contender& contender) : contender_(contender) {}

  std::unique_ptr<Writer> writer(const std::string& topic, const Messages& messages) override {
    return std::make_unique<FastDdsWriter>(participant_, topic, messages, contender_);
  }
  std::unique_ptr<Reader> reader(const std::string& topic, const Messages& messages, FieldSet,
                                 Arrived arrived) override {
    return std::make_unique<FastDdsReader>(participant_, topic, messages, contender_, std::move(arrived));
  }

 private:
  const Contender contender_;
  fast::Participant participant_{std::make_shared<fast::transports::UDPv4TransportDescriptor>()};
};

}  // namespace

std::unique_ptr<Peer> open_fast_dds(const Contender& contender) {
  return std::make_unique<FastDdsPeer>(contender);
}

}  // namespace sft::bench::paper
