// A control topic, as one participant has it: its reader and its writer are made when they are needed first.
// Each of them meets those of all other nodes, which costs all of them messages. One thread at a time.
#pragma once

#include <dds/dds.h>

#include <memory>
#include <utility>

#include "core/discovery/control_qos.h"
#include "sft/result.h"

namespace sft::core {

struct ListenerDeleter {
  void operator()(dds_listener_t* listener) const { dds_delete_listener(listener); }
};
using DdsListener = std::unique_ptr<dds_listener_t, ListenerDeleter>;

class ControlTopic {
 public:
  struct Kind {
    const dds_topic_descriptor_t* type = nullptr;
    const char* name = nullptr;
    dds_on_data_available_fn on_data = nullptr;
  };
  /// What Cyclone calls on its threads, with `self`.
  struct Matches {
    void* self = nullptr;
    dds_on_subscription_matched_fn on_subscription = nullptr;
    dds_on_publication_matched_fn on_publication = nullptr;
  };
  /// The participant deletes what is made here.
  ControlTopic(dds_entity_t participant, const Kind& kind, const Matches& matches, DdsQos qos)
      : participant_(participant), kind_(kind), matches_(matches), qos_(std::move(qos)) {}

  /// Makes the reader, unless it is there.
  Result<void> hear();
  /// Returns the writer, which is made unless it is there.
  Result<dds_entity_t> writer();
  /// 0 if nothing has been written yet.
  dds_entity_t known_writer() const { return writer_; }

 private:
  Result<void> open();
  Result<dds_entity_t> made(dds_entity_t entity) const;

  const dds_entity_t participant_;
  const Kind kind_;
  const Matches matches_;
  const DdsQos qos_;
  dds_entity_t topic_ = 0;
  dds_entity_t reader_ = 0;
  dds_entity_t writer_ = 0;
};

}  // namespace sft::core
