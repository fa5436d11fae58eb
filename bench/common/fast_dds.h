// Fast DDS, used as in a program without SFT. There is only one header, because Fast DDS's headers are slow
// to compile. Each program includes it in one source only.
#pragma once

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>
#include <memory>
#include <new>
#include <span>

#include "bench/common/fast_dds_version.h"

namespace sft::bench {

namespace fast {

inline constexpr std::uint32_t encapsulation_bytes = 4;
inline constexpr std::uint8_t little_endian[encapsulation_bytes] = {0, 1, 0, 0};

[[noreturn]] inline void give_up(const char* what) {
  std::fprintf(stderr, "Fast DDS: %s\n", what);
  std::exit(1);
}

template <class T>
T& checked(T* entity, const char* what) {
  if (entity == nullptr) give_up(what);
  return *entity;
}

/// The type support of a message, in place of code from the generator of Fast DDS.
template <class T>
class Type : public AnyType {
 public:
  Type(const char* name, std::uint32_t bytes) { set(name, encapsulation_bytes + bytes); }

 protected:
  void* make() override { return new T(); }
  void unmake(void* data) override { delete static_cast<T*>(data); }

  static std::span<std::byte> body(const rtps::SerializedPayload_t& payload, std::size_t end) {
    return {reinterpret_cast<std::byte*>(payload.data) + encapsulation_bytes, end - encapsulation_bytes};
  }
  static void encapsulate(rtps::SerializedPayload_t& payload, std::size_t body_bytes) {
    payload.encapsulation = CDR_LE;
    std::memcpy(payload.data, little_endian, encapsulation_bytes);
    payload.length = static_cast<std::uint32_t>(encapsulation_bytes + body_bytes);
  }
};

/// The type support of messages whose bytes in memory are the same as on the wire.
template <class T>
class PlainType : public Type<T> {
 public:
  explicit PlainType(const char* name) : Type<T>(name, sizeof(T)) {}

  bool is_bounded() const override { return true; }
  bool construct_sample(void* memory) const override {
    new (memory) T;
    return true;
  }

 protected:
  void encode(const void* data, rtps::SerializedPayload_t& payload) override {
    Type<T>::encapsulate(payload, sizeof(T));
    std::memcpy(payload.data + encapsulation_bytes, data, sizeof(T));
  }
  bool decode(rtps::SerializedPayload_t& payload, void* data) override {
    std::memcpy(data, payload.data + encapsulation_bytes, sizeof(T));
    return true;
  }
  std::uint32_t encoded_bytes(const void*) override { return encapsulation_bytes + sizeof(T); }
  bool is_same_in_memory() const override { return true; }
};

/// Sets the QoS of a writer or reader to best effort, volatile, and keep last 1. The memory of a sample
/// grows as needed.
template <class Qos>
Qos best_effort(Qos qos) {
  qos.reliability().kind = dds::BEST_EFFORT_RELIABILITY_QOS;
  qos.durability().kind = dds::VOLATILE_DURABILITY_QOS;
  qos.history().kind = dds::KEEP_LAST_HISTORY_QOS;
  qos.history().depth = 1;
  qos.endpoint().history_memory_policy = rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
  return qos;
}

/// A participant in domain 0 with the transports that are passed.
class Participant {
 public:
  template <class... TransportDescriptors>
  requires(sizeof...(TransportDescriptors) >
           0) explicit Participant(std::shared_ptr<TransportDescriptors>... transports) {
    dds::DomainParticipantQos qos;
    qos.transport().use_builtin_transports = false;
    (qos.transport().user_transports.push_back(std::move(transports)), ...);
    participant_ = &checked(factory().create_participant(0, qos), "participant");
  }
  ~Participant() {
    participant_->delete_contained_entities();
    factory().delete_participant(participant_);
  }
  Participant(const Participant&) = delete;
  Participant& operator=(const Participant&) = delete;

  /// Returns the topic with this name and type. Takes ownership of `type`.
  dds::Topic& topic(const char* name, AnyType* type) {
    const dds::TypeSupport support(type);
    support.register_type(participant_);
    return checked(participant_->create_topic(name, type->name(), dds::TOPIC_QOS_DEFAULT), "topic");
  }
  dds::DataWriter& writer(dds::Topic& topic, const dds::DataWriterQos& qos) {
    auto& publisher = checked(participant_->create_publisher(dds::PUBLISHER_QOS_DEFAULT), "publisher");
    return checked(publisher.create_datawriter(&topic, qos), "writer");
  }
  dds::DataReader& reader(dds::Topic& topic, const dds::DataReaderQos& qos,
                          dds::DataReaderListener* listener) {
    auto& subscriber = checked(participant_->create_subscriber(dds::SUBSCRIBER_QOS_DEFAULT), "subscriber");
    return checked(subscriber.create_datareader(&topic, qos, listener), "reader");
  }

 private:
  static dds::DomainParticipantFactory& factory() { return *dds::DomainParticipantFactory::get_instance(); }

  dds::DomainParticipant* participant_ = nullptr;
};

/// Return the number of readers that are matched with `writer`, and the number of writers that are matched
/// with `reader`.
inline std::size_t readers(const dds::DataWriter& writer) {
  dds::PublicationMatchedStatus status;
  writer.get_publication_matched_status(status);
  return static_cast<std::size_t>(status.current_count);
}
inline std::size_t writers(const dds::DataReader& reader) {
  dds::SubscriptionMatchedStatus status;
  reader.get_subscription_matched_status(status);
  return static_cast<std::size_t>(status.current_count);
}

}  // namespace fast

}  // namespace sft::bench
