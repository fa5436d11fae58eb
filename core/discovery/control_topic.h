// A control topic, as one participant has it: it shares the reader with other nodes of its process, and has a
// writer of its own. Both are made when they are needed first, since each of them meets those of all other
// nodes, which costs all of them messages. One thread at a time.
#pragma once

#include <dds/dds.h>

#include <memory>
#include <utility>

#include "core/discovery/control_qos.h"
#include "core/discovery/joint_reader.h"
#include "sft/result.h"

namespace sft::core {

class ControlTopic {
 public:
  /// What Cyclone calls on its threads, with `self`.
  struct Matches {
    void* self = nullptr;
    dds_on_publication_matched_fn on_publication = nullptr;
  };
  /// `readers` outlive this object. The participant of the hearer deletes the writer.
  ControlTopic(std::shared_ptr<Hearer> hearer, JointReaders& readers, const JointReader::Kind& kind,
               const Matches& matches, DdsQos qos)
      : hearer_(std::move(hearer)), readers_(readers), kind_(kind), matches_(matches), qos_(std::move(qos)) {}
  /// Hears nothing any more.
  ~ControlTopic();
  ControlTopic(const ControlTopic&) = delete;
  ControlTopic& operator=(const ControlTopic&) = delete;

  /// Hears what others say, from now on.
  Result<void> hear();
  /// Returns the writer, which is made unless it is there.
  Result<dds_entity_t> writer();
  /// 0 if nothing has been written yet.
  dds_entity_t known_writer() const { return writer_; }

 private:
  const std::shared_ptr<Hearer> hearer_;
  JointReaders& readers_;
  const JointReader::Kind kind_;
  const Matches matches_;
  const DdsQos qos_;
  std::shared_ptr<JointReader> reader_;  ///< once this node hears the topic
  dds_entity_t writer_ = 0;
};

}  // namespace sft::core
