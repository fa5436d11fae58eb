// A node of Fast DDS with the code of its own generator, which knows nothing of SFT. It takes the clouds of
// one topic as structs, and writes each of them to another topic. It writes the number of endpoints that
// match its own two to its standard output whenever that changes.
//
// fast_dds_echo DOMAIN FROM TO reliable|best_effort volatile|latched DEPTH
#include <sys/prctl.h>
#include <unistd.h>

#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/DataWriterListener.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>
#include <mutex>
#include <string_view>

#include "VanillaMessagesPubSubTypes.h"

namespace {

namespace fast = eprosima::fastdds::dds;
using eprosima::fastrtps::types::ReturnCode_t;
using sensor_msgs::msg::dds_::PointCloud2_;
using sensor_msgs::msg::dds_::PointCloud2_PubSubType;

/// Threads of Fast DDS call it.
class Matches : public fast::DataReaderListener, public fast::DataWriterListener {
 public:
  void on_subscription_matched(fast::DataReader*, const fast::SubscriptionMatchedStatus& status) override {
    report(status.current_count_change);
  }
  void on_publication_matched(fast::DataWriter*, const fast::PublicationMatchedStatus& status) override {
    report(status.current_count_change);
  }

 private:
  void report(int change) {
    const std::lock_guard lock(mutex_);
    matched_ += static_cast<std::uint32_t>(change);
    if (write(STDOUT_FILENO, &matched_, sizeof matched_) != sizeof matched_) std::_Exit(0);  // the test ended
  }

  std::mutex mutex_;
  std::uint32_t matched_ = 0;
};

template <class Qos>
Qos qos_of(char** words, Qos qos) {
  const bool reliable = std::string_view(words[0]) == "reliable";
  const bool latched = std::string_view(words[1]) == "latched";
  qos.reliability().kind = reliable ? fast::RELIABLE_RELIABILITY_QOS : fast::BEST_EFFORT_RELIABILITY_QOS;
  qos.durability().kind = latched ? fast::TRANSIENT_LOCAL_DURABILITY_QOS : fast::VOLATILE_DURABILITY_QOS;
  qos.history().kind = fast::KEEP_LAST_HISTORY_QOS;
  qos.history().depth = std::atoi(words[2]);
  qos.endpoint().history_memory_policy = eprosima::fastrtps::rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
  return qos;
}

/// The buffer holds a burst of one sample. A participant that was killed is gone soon.
fast::DomainParticipantQos participant_qos() {
  fast::DomainParticipantQos qos;
  qos.transport().listen_socket_buffer_size = 4 << 20;
  auto& discovery = qos.wire_protocol().builtin.discovery_config;
  discovery.leaseDuration = {2, 0};
  discovery.leaseDuration_announcementperiod = {0, 500'000'000};
  return qos;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 7) return 2;
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  fast::DomainParticipant* const participant =
      fast::DomainParticipantFactory::get_instance()->create_participant(
          static_cast<std::uint32_t>(std::atoi(argv[1])), participant_qos());
  fast::TypeSupport type(new PointCloud2_PubSubType);
  type.register_type(participant);
  const auto topic = [&](const char* name) {
    return participant->create_topic(name, type.get_type_name(), fast::TOPIC_QOS_DEFAULT);
  };
  Matches matches;
  fast::DataWriterQos writer_qos = qos_of(argv + 4, fast::DATAWRITER_QOS_DEFAULT);
  writer_qos.publish_mode().kind = fast::ASYNCHRONOUS_PUBLISH_MODE;  // as in ROS 2
  fast::DataWriter* const writer = participant->create_publisher(fast::PUBLISHER_QOS_DEFAULT)
                                       ->create_datawriter(topic(argv[3]), writer_qos, &matches);
  fast::DataReader* const reader =
      participant->create_subscriber(fast::SUBSCRIBER_QOS_DEFAULT)
          ->create_datareader(topic(argv[2]), qos_of(argv + 4, fast::DATAREADER_QOS_DEFAULT), &matches);
  if (writer == nullptr || reader == nullptr) return 3;
  PointCloud2_ message;
  fast::SampleInfo info;
  for (;;) {
    reader->wait_for_unread_message({1, 0});
    while (reader->take_next_sample(&message, &info) == ReturnCode_t::RETCODE_OK)
      if (info.valid_data && !writer->write(&message)) return 4;
  }
}
