#include "core/discovery/control_topic.h"

#include <optional>

namespace sft::core {

Result<void> ControlTopic::hear() {
  if (reader_ != 0) return {};
  const DdsListener listener(dds_create_listener(this));
  dds_lset_data_available(listener.get(), &on_data);
  dds_lset_subscription_matched(listener.get(), &on_subscription);
  const DdsQos qos = hearing_qos(qos_.get());
  const Result<dds_entity_t> made = create_on_topic(
      participant_, kind_.name, qos_.get(),
      [&](dds_entity_t topic) { return dds_create_reader(participant_, topic, qos.get(), listener.get()); });
  if (!made) return tl::unexpected(made.error());
  reader_ = *made;
  return {};
}

Result<dds_entity_t> ControlTopic::writer() {
  if (writer_ != 0) return writer_;
  const DdsListener listener(dds_create_listener(this));
  dds_lset_publication_matched(listener.get(), &on_publication);
  Result<dds_entity_t> made = create_on_topic(participant_, kind_.name, qos_.get(), [&](dds_entity_t topic) {
    return dds_create_writer(participant_, topic, qos_.get(), listener.get());
  });
  if (made) writer_ = *made;
  return made;
}

void ControlTopic::take(dds_entity_t reader) {
  const Lock telling(telling_);
  ControlWords words;
  {
    const Lock lock(mutex_);
    words = kind_.take(reader, heard_);
  }
  for (const ControlWord& word : words) hear_(word);
}

void ControlTopic::matched(dds_instance_handle_t other, bool has_come,
                           const std::optional<Participants::Guid>& participant) {
  if (has_come && !participant) return;
  const Lock telling(telling_);
  std::optional<ControlWord> word;
  {
    const Lock lock(mutex_);
    word = has_come ? matches_.met(other, *participant) : matches_.gone(other);
  }
  if (word) hear_(*word);
}

void ControlTopic::on_data(dds_entity_t reader, void* self) {
  static_cast<ControlTopic*>(self)->take(reader);
}

void ControlTopic::on_subscription(dds_entity_t reader, const dds_subscription_matched_status_t status,
                                   void* self) {
  const dds_instance_handle_t writer = status.last_publication_handle;
  const bool has_come = status.current_count_change > 0;
  static_cast<ControlTopic*>(self)->matched(writer, has_come,
                                            has_come ? publishing_participant(reader, writer) : std::nullopt);
}

void ControlTopic::on_publication(dds_entity_t writer, const dds_publication_matched_status_t status,
                                  void* self) {
  const dds_instance_handle_t reader = status.last_subscription_handle;
  const bool has_come = status.current_count_change > 0;
  static_cast<ControlTopic*>(self)->matched(
      reader, has_come, has_come ? subscribing_participant(writer, reader) : std::nullopt);
}

}  // namespace sft::core
