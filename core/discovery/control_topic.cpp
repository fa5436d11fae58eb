#include "core/discovery/control_topic.h"

#include "core/discovery/topic_endpoint.h"

namespace sft::core {

ControlTopic::~ControlTopic() {
  if (reader_ != nullptr) reader_->leave(hearer_);
}

Result<void> ControlTopic::hear() {
  for (;;) {
    std::shared_ptr<JointReader> reader = reader_ == nullptr ? readers_.of(kind_, qos_.get()) : reader_;
    const Result<bool> joined = reader->join(hearer_);
    if (!joined) return tl::unexpected(joined.error());
    if (!*joined) continue;  // there is another one now
    reader_ = std::move(reader);
    return {};
  }
}

Result<dds_entity_t> ControlTopic::writer() {
  if (writer_ != 0) return writer_;
  const DdsListener listener(dds_create_listener(matches_.self));
  dds_lset_publication_matched(listener.get(), matches_.on_publication);
  const dds_entity_t participant = hearer_->participant();
  Result<dds_entity_t> made = create_on_topic(participant, kind_.topic, qos_.get(), [&](dds_entity_t topic) {
    return dds_create_writer(participant, topic, qos_.get(), listener.get());
  });
  if (made) writer_ = *made;
  return made;
}

}  // namespace sft::core
