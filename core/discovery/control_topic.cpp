#include "core/discovery/control_topic.h"

#include <string>

namespace sft::core {

Result<dds_entity_t> ControlTopic::made(dds_entity_t entity) const {
  if (entity >= 0) return entity;
  return fail(Errc::system, std::string("control topic ") + kind_.name + ": " + dds_strretcode(entity));
}

Result<void> ControlTopic::open() {
  if (topic_ != 0) return {};
  return made(dds_create_topic(participant_, kind_.type, kind_.name, qos_.get(), nullptr))
      .map([this](dds_entity_t topic) { topic_ = topic; });
}

Result<void> ControlTopic::hear() {
  if (reader_ != 0) return {};
  if (Result<void> opened = open(); !opened) return opened;
  const DdsListener listener(dds_create_listener(matches_.self));
  dds_lset_data_available(listener.get(), kind_.on_data);
  dds_lset_subscription_matched(listener.get(), matches_.on_subscription);
  return made(dds_create_reader(participant_, topic_, hearing_qos(qos_.get()).get(), listener.get()))
      .map([this](dds_entity_t reader) { reader_ = reader; });
}

Result<dds_entity_t> ControlTopic::writer() {
  if (writer_ != 0) return writer_;
  if (Result<void> opened = open(); !opened) return tl::unexpected(opened.error());
  const DdsListener listener(dds_create_listener(matches_.self));
  dds_lset_publication_matched(listener.get(), matches_.on_publication);
  Result<dds_entity_t> writer = made(dds_create_writer(participant_, topic_, qos_.get(), listener.get()));
  if (writer) writer_ = *writer;
  return writer;
}

}  // namespace sft::core
