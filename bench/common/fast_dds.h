// Fast DDS, used as in a program without SFT. There is only one header, because Fast DDS's headers are slow
// to compile. Each program includes it in one source only.
#pragma once

#include <cstdio>
#include <cstdlib>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>
#include <memory>

#include "bench/common/fast_dds_version.h"

namespace sft::bench {

namespace fast {

[[noreturn]] inline void give_up(const char* what) {
  std::fprintf(stderr, "Fast DDS: %s\n", what);
  std::exit(1);
}

template <class T>
T& checked(T* entity, const char* what) {
  if (entity == nullptr) give_up(what);
  return *entity;
}

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
  dds::Topic& topic(const char* name, BodyType* type) {
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
