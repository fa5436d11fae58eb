// A control topic on one link: one reader and one writer for all nodes of the process. Each is made when it
// is needed first, since it meets those of all other processes, which costs all of them messages.
#pragma once

#include <dds/dds.h>

#include <functional>
#include <utility>

#include "core/discovery/control_qos.h"
#include "core/discovery/control_word.h"
#include "core/discovery/control_words.h"
#include "core/discovery/matches.h"
#include "core/discovery/topic_endpoint.h"
#include "core/sync/mutex.h"
#include "sft/result.h"

namespace sft::core {

class ControlTopic {
 public:
  struct Kind {
    TopicName name;
    ControlWords (*take)(dds_entity_t reader, Heard& heard) = nullptr;
  };
  /// Gets what others say, in their order and one word at a time. It is called on Cyclone's threads.
  using Hear = std::function<void(const ControlWord&)>;

  /// The participant ends before this object, and with it reader and writer.
  ControlTopic(dds_entity_t participant, const Kind& kind, DdsQos qos, Hear hear)
      : participant_(participant), kind_(kind), qos_(std::move(qos)), hear_(std::move(hear)) {}
  ControlTopic(const ControlTopic&) = delete;
  ControlTopic& operator=(const ControlTopic&) = delete;

  // One thread at a time.

  /// Hears what others say, from now on, and what is in force of what they have said before.
  Result<void> hear();
  /// Returns the writer, which is made unless it is there.
  Result<dds_entity_t> writer();
  /// 0 if nothing has been written yet.
  dds_entity_t known_writer() const { return writer_; }

  /// The participant is not there any more. Any thread.
  void forget(const Participants::Guid& participant) {
    const Lock lock(mutex_);
    heard_.writers.forget(participant);
    heard_.keys.forget(participant);
  }

 private:
  void take(dds_entity_t reader);
  void matched(dds_instance_handle_t other, bool has_come,
               const std::optional<Participants::Guid>& participant);
  static void on_data(dds_entity_t reader, void* self);
  static void on_subscription(dds_entity_t reader, dds_subscription_matched_status_t status, void* self);
  static void on_publication(dds_entity_t writer, dds_publication_matched_status_t status, void* self);

  const dds_entity_t participant_;
  const Kind kind_;
  const DdsQos qos_;
  const Hear hear_;
  dds_entity_t reader_ = 0, writer_ = 0;

  /// Held while words are taken and heard, so that they are heard in their order. Who hears them notes them:
  /// that neither waits for anything nor speaks.
  Mutex telling_ SFT_ACQUIRED_BEFORE(mutex_);
  Mutex mutex_;
  Heard heard_ SFT_GUARDED_BY(mutex_);
  Matches matches_ SFT_GUARDED_BY(mutex_);  ///< readers and writers of others that ours have met
};

}  // namespace sft::core
