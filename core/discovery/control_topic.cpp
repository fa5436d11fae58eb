#include "core/discovery/control_topic.h"

namespace sft::core {

ControlTopic::~ControlTopic() {
  if (reader_ != nullptr) reader_->leave(hearer_);
}

Result<void> ControlTopic::hear() {
  if (reader_ != nullptr) return reader_->join(hearer_);
  std::shared_ptr<JointReader> reader = readers_.of(kind_, qos_.get());
  Result<void> joined = reader->join(hearer_);
  if (joined) reader_ = std::move(reader);
  return joined;
}

Result<dds_entity_t> ControlTopic::writer() {
  if (writer_ != 0) return writer_;
  const DdsListener listener(dds_create_listener(matches_.self));
  dds_lset_publication_matched(listener.get(), matches_.on_publication);
  const dds_entity_t participant = hearer_->participant();
  Result<dds_entity_t> made = create_on_topic(participant, kind_, qos_.get(), [&](dds_entity_t topic) {
    return dds_create_writer(participant, topic, qos_.get(), listener.get());
  });
  if (made) writer_ = *made;
  return made;
}

}  // namespace sft::core
