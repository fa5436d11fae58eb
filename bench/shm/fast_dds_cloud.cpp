#include "bench/shm/fast_dds_cloud.h"

#include <fastdds/rtps/transport/shared_mem/SharedMemTransportDescriptor.h>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fastdds/dds/core/LoanableSequence.hpp>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>

#include "bench/common/cloud.h"
#include "bench/common/fast_cdr.h"

namespace sft::bench {

namespace {

namespace dds = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;
using eprosima::fastrtps::types::ReturnCode_t;
using Standard = sensor_msgs::msg::PointCloud2;

struct Fixed {
  std::uint32_t height;
  std::uint32_t width;
  std::uint8_t data[sent_cloud_bytes];
};

// The best of what was tried, from pieces of 64 KB to the whole cloud in one: while a piece is read the next
// one is written.
constexpr std::uint32_t message_bytes_max = 1'000'000;
constexpr std::uint32_t segment_bytes = 20'000'000;
constexpr std::uint32_t encapsulation_bytes = 4;
constexpr std::uint8_t little_endian[encapsulation_bytes] = {0, 1, 0, 0};

[[noreturn]] void give_up(const char* what) {
  std::fprintf(stderr, "Fast DDS: %s\n", what);
  std::exit(1);
}

template <class T>
T& checked(T* entity, const char* what) {
  if (entity == nullptr) give_up(what);
  return *entity;
}

/// What is generated for a type, by hand.
template <class T>
class Type : public dds::TopicDataType {
 public:
  Type(const char* name, std::uint32_t bytes) {
    setName(name);
    m_typeSize = encapsulation_bytes + bytes;
    auto_fill_type_object(false);
    auto_fill_type_information(false);
  }

  void* createData() override { return new T(); }
  void deleteData(void* data) override { delete static_cast<T*>(data); }
  bool getKey(void*, rtps::InstanceHandle_t*, bool) override { return false; }

 protected:
  static std::span<std::byte> body(const rtps::SerializedPayload_t& payload, std::size_t end) {
    return {reinterpret_cast<std::byte*>(payload.data) + encapsulation_bytes, end - encapsulation_bytes};
  }
  static void encapsulate(rtps::SerializedPayload_t& payload, std::size_t body_bytes) {
    payload.encapsulation = CDR_LE;
    std::memcpy(payload.data, little_endian, encapsulation_bytes);
    payload.length = static_cast<std::uint32_t>(encapsulation_bytes + body_bytes);
  }
};

class StandardType : public Type<Standard> {
 public:
  // Memory grows to what a message takes, once.
  StandardType() : Type("sensor_msgs::msg::dds_::PointCloud2_", 1024) {}

  bool serialize(void* data, rtps::SerializedPayload_t* payload) override {
    FastCdrWriter writer(body(*payload, payload->max_size));
    members(writer, *static_cast<Standard*>(data));
    encapsulate(*payload, writer.bytes());
    return true;
  }
  bool deserialize(rtps::SerializedPayload_t* payload, void* data) override {
    FastCdrReader reader(body(*payload, payload->length));
    members(reader, *static_cast<Standard*>(data));
    return true;
  }
  std::function<std::uint32_t()> getSerializedSizeProvider(void* data) override {
    constexpr std::size_t small_members_max = 1024;
    return [data] {
      return static_cast<std::uint32_t>(static_cast<Standard*>(data)->data.size() + small_members_max);
    };
  }
};

/// The same bytes in memory and on the wire.
class FixedType : public Type<Fixed> {
 public:
  FixedType() : Type("sft_bench::FixedCloud", sizeof(Fixed)) {}

  bool serialize(void* data, rtps::SerializedPayload_t* payload) override {
    encapsulate(*payload, sizeof(Fixed));
    std::memcpy(payload->data + encapsulation_bytes, data, sizeof(Fixed));
    return true;
  }
  bool deserialize(rtps::SerializedPayload_t* payload, void* data) override {
    std::memcpy(data, payload->data + encapsulation_bytes, sizeof(Fixed));
    return true;
  }
  std::function<std::uint32_t()> getSerializedSizeProvider(void*) override {
    return [] { return std::uint32_t{encapsulation_bytes + sizeof(Fixed)}; };
  }
  bool is_bounded() const override { return true; }
  bool is_plain() const override { return true; }
  bool construct_sample(void* memory) const override {
    new (memory) Fixed;
    return true;
  }
};

dds::DomainParticipant& open_participant() {
  auto transport = std::make_shared<eprosima::fastdds::rtps::SharedMemTransportDescriptor>();
  transport->segment_size(segment_bytes);
  transport->max_message_size(message_bytes_max);
  dds::DomainParticipantQos qos;
  qos.transport().use_builtin_transports = false;
  qos.transport().user_transports.push_back(transport);
  return checked(dds::DomainParticipantFactory::get_instance()->create_participant(0, qos), "participant");
}

/// For writers and readers.
template <class Qos>
Qos best_effort(Qos qos) {
  qos.reliability().kind = dds::BEST_EFFORT_RELIABILITY_QOS;
  qos.durability().kind = dds::VOLATILE_DURABILITY_QOS;
  qos.history().kind = dds::KEEP_LAST_HISTORY_QOS;
  qos.history().depth = 1;
  qos.endpoint().history_memory_policy = rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
  return qos;
}

class Participant {
 public:
  explicit Participant(dds::TopicDataType* type) : participant_(open_participant()) {
    const dds::TypeSupport support(type);  // owns it
    support.register_type(&participant_);
    topic_ = &checked(participant_.create_topic("points", type->getName(), dds::TOPIC_QOS_DEFAULT), "topic");
  }
  ~Participant() {
    participant_.delete_contained_entities();
    dds::DomainParticipantFactory::get_instance()->delete_participant(&participant_);
  }
  Participant(const Participant&) = delete;
  Participant& operator=(const Participant&) = delete;

  dds::DataWriter& writer() {
    auto& publisher = checked(participant_.create_publisher(dds::PUBLISHER_QOS_DEFAULT), "publisher");
    return checked(publisher.create_datawriter(topic_, best_effort(dds::DATAWRITER_QOS_DEFAULT)), "writer");
  }
  dds::DataReader& reader(dds::DataReaderListener& listener) {
    auto& subscriber = checked(participant_.create_subscriber(dds::SUBSCRIBER_QOS_DEFAULT), "subscriber");
    return checked(subscriber.create_datareader(topic_, best_effort(dds::DATAREADER_QOS_DEFAULT), &listener),
                   "reader");
  }

 private:
  dds::DomainParticipant& participant_;
  dds::Topic* topic_ = nullptr;
};

class Writer {
 public:
  explicit Writer(dds::TopicDataType* type) : participant_(type), writer_(participant_.writer()) {}

  bool serves(std::size_t readers) const {
    dds::PublicationMatchedStatus status;
    writer_.get_publication_matched_status(status);
    return status.current_count == static_cast<std::int32_t>(readers);
  }

 protected:
  Participant participant_;
  dds::DataWriter& writer_;
};

class StandardWriter : public Writer {
 public:
  StandardWriter() : Writer(new StandardType) {}
  void prepare(std::uint64_t number) { cloud_.width = static_cast<std::uint32_t>(number); }
  void publish() { writer_.write(&cloud_); }

 private:
  Standard cloud_ = cloud(sent_cloud_bytes);
};

class FixedWriter : public Writer {
 public:
  FixedWriter() : Writer(new FixedType) {}
  void prepare(std::uint64_t number) {
    if (writer_.loan_sample(loan_) != ReturnCode_t::RETCODE_OK) give_up("no loan");
    auto& cloud = *static_cast<Fixed*>(loan_);
    cloud.height = 1;
    cloud.width = static_cast<std::uint32_t>(number);
  }
  void publish() { writer_.write(loan_); }

 private:
  void* loan_ = nullptr;
};

class Reader : private dds::DataReaderListener {
 public:
  std::size_t writers() const {
    dds::SubscriptionMatchedStatus status;
    reader_.get_subscription_matched_status(status);
    return static_cast<std::size_t>(status.current_count);
  }

 protected:
  Reader(dds::TopicDataType* type, Arrived arrived)
      : arrived_(std::move(arrived)), participant_(type), reader_(participant_.reader(*this)) {}

  const Arrived arrived_;

 private:
  Participant participant_;
  dds::DataReader& reader_;
};

/// Deserializes into the same memory again and again.
class StandardReader : public Reader {
 public:
  explicit StandardReader(Arrived arrived) : Reader(new StandardType, std::move(arrived)) {}

 private:
  void on_data_available(dds::DataReader* reader) override {
    dds::SampleInfo info;
    while (reader->take_next_sample(&cloud_, &info) == ReturnCode_t::RETCODE_OK) {
      if (info.valid_data) arrived_(std::uint64_t{cloud_.height} * cloud_.width);
    }
  }

  Standard cloud_;
};

/// Reads in place.
class FixedReader : public Reader {
 public:
  explicit FixedReader(Arrived arrived) : Reader(new FixedType, std::move(arrived)) {}

 private:
  void on_data_available(dds::DataReader* reader) override {
    dds::LoanableSequence<Fixed> clouds;
    dds::SampleInfoSeq infos;
    while (reader->take(clouds, infos) == ReturnCode_t::RETCODE_OK) {
      for (dds::LoanableCollection::size_type i = 0; i < infos.length(); ++i) {
        if (infos[i].valid_data) arrived_(std::uint64_t{clouds[i].height} * clouds[i].width);
      }
      reader->return_loan(clouds, infos);
    }
  }
};

template <class W, class R>
std::vector<double> times(const Transfer& transfer) {
  return run_pair({.sender =
                       [&](Exchange& exchange) {
                         W writer;
                         send_each(exchange, transfer, writer);
                       },
                   .receiver = [&](Exchange& exchange) { be_called<R>(exchange, transfer); }},
                  transfer.messages);
}

}  // namespace

std::vector<double> fast_dds_standard(const Transfer& transfer) {
  return times<StandardWriter, StandardReader>(transfer);
}

std::vector<double> fast_dds_fixed(const Transfer& transfer) {
  return times<FixedWriter, FixedReader>(transfer);
}

}  // namespace sft::bench
