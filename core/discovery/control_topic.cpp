#include "core/discovery/control_topic.h"

#include <string>

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
  dds_entity_t made = dds_create_topic(hearer_->participant(), kind_.type, kind_.name, qos_.get(), nullptr);
  if (made >= 0) made = dds_create_writer(hearer_->participant(), made, qos_.get(), listener.get());
  if (made < 0)
    return fail(Errc::system, std::string("control topic ") + kind_.name + ": " + dds_strretcode(made));
  writer_ = made;
  return made;
}

}  // namespace sft::core
