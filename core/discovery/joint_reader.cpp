#include "core/discovery/joint_reader.h"

#include <algorithm>
#include <memory>
#include <optional>
#include <ranges>

namespace sft::core {

Result<bool> JointReader::join(const std::shared_ptr<Hearer>& hearer) {
  const Lock joining(joining_);
  {
    const Lock telling(telling_);
    Words in_force;
    {
      const Lock lock(mutex_);
      if (std::ranges::find(*hearers_, hearer) == hearers_->end()) {
        if (!kept_.are_complete()) return false;
        auto more = std::make_shared<Hearers>(*hearers_);
        more->push_back(hearer);
        hearers_ = std::move(more);
        in_force = kept_.all();
      }
    }
    if (host_ != nullptr) {
      tell(in_force, {hearer});
      return true;
    }
  }
  if (Result<void> hosted = host(hearer); !hosted) {
    hearers_without(hearer);
    return tl::unexpected(hosted.error());
  }
  return true;
}

/// The new reader is there before the former one ends. The latest hearer gets it: if nodes end in the order
/// in which they were made, the reader moves once.
void JointReader::leave(const std::shared_ptr<Hearer>& hearer) {
  const Lock joining(joining_);
  const std::shared_ptr<const Hearers> others = hearers_without(hearer);
  if (host_ != hearer) return;
  const dds_entity_t former = reader_;
  host_.reset();
  Result<void> hosted;
  for (const std::shared_ptr<Hearer>& other : *others | std::views::reverse) {
    if (hosted = host(other); hosted) break;
  }
  hear(former);  // what has ended since then, the new one has never heard of
  dds_delete(former);
  if (host_ != nullptr) return;
  const Lock telling(telling_);
  {
    const Lock lock(mutex_);
    kept_.clear();
    writers_ = {};
    matches_ = {};
  }
  if (!hosted)
    tell({std::make_shared<const ControlWord>(std::nullopt, SampleMalformed{hosted.error().message})},
         *others);
}

void JointReader::forget(const Participants::Guid& participant) {
  const Lock lock(mutex_);
  writers_.forget(participant);
  kept_.forget(participant);
}

Result<void> JointReader::host(const std::shared_ptr<Hearer>& hearer) {
  const DdsListener listener(dds_create_listener(this));
  dds_lset_data_available(listener.get(), &on_data);
  dds_lset_subscription_matched(listener.get(), &on_matched);
  const DdsQos qos = hearing_qos(qos_.get());
  const dds_entity_t participant = hearer->participant();
  const Result<dds_entity_t> reader = create_on_topic(
      participant, kind_.topic, qos_.get(),
      [&](dds_entity_t topic) { return dds_create_reader(participant, topic, qos.get(), listener.get()); });
  if (!reader) return tl::unexpected(reader.error());
  host_ = hearer;
  reader_ = *reader;
  return {};
}

std::shared_ptr<const JointReader::Hearers> JointReader::hearers_without(
    const std::shared_ptr<Hearer>& hearer) {
  const Lock lock(mutex_);
  auto fewer = std::make_shared<Hearers>(*hearers_);
  std::erase(*fewer, hearer);
  hearers_ = std::move(fewer);
  return hearers_;
}

void JointReader::hear(dds_entity_t reader) {
  const Lock telling(telling_);
  Words words;
  std::shared_ptr<const Hearers> hearers;
  {
    const Lock lock(mutex_);
    words = kept(kind_.take(reader, writers_));
    hearers = hearers_;
  }
  tell(words, *hearers);
}

JointReader::Words JointReader::kept(ControlWords words) {
  Words all;
  for (ControlWord& word : words) {
    all.push_back(std::make_shared<const ControlWord>(std::move(word)));
    kept_.learn(all.back());
  }
  return all;
}

void JointReader::tell(const Words& words, const Hearers& hearers) {
  for (const KeptWords::Word& word : words) {
    for (const std::shared_ptr<Hearer>& hearer : hearers) hearer->hear(*word);
  }
}

void JointReader::on_data(dds_entity_t reader, void* self) { static_cast<JointReader*>(self)->hear(reader); }

/// What a new reader of ours meets after a former one has met it already is no news.
void JointReader::on_matched(dds_entity_t reader, const dds_subscription_matched_status_t status,
                             void* self) {
  JointReader& joint = *static_cast<JointReader*>(self);
  const dds_instance_handle_t writer = status.last_publication_handle;
  const bool has_come = status.current_count_change > 0;
  std::optional<Participants::Guid> participant;
  if (has_come) participant = publishing_participant(reader, writer);
  if (has_come && !participant) return;
  const Lock telling(joint.telling_);
  std::optional<ControlWord> word;
  std::shared_ptr<const Hearers> hearers;
  {
    const Lock lock(joint.mutex_);
    word = has_come ? joint.matches_.met(writer, *participant) : joint.matches_.gone(writer);
    hearers = joint.hearers_;
  }
  if (word) tell({std::make_shared<const ControlWord>(std::move(*word))}, *hearers);
}

std::shared_ptr<JointReader> JointReaders::of(const JointReader::Kind& kind, const dds_qos_t* qos) {
  const Lock lock(mutex_);
  std::shared_ptr<JointReader>& reader = readers_[kind.topic.name];
  if (reader != nullptr && reader->takes_newcomers()) return reader;
  std::erase_if(former_, [](const auto& former) { return former.expired(); });
  if (reader != nullptr) former_.push_back(reader);
  reader = std::make_shared<JointReader>(kind, qos);
  return reader;
}

void JointReaders::forget(const Participants::Guid& participant) {
  std::vector<std::shared_ptr<JointReader>> readers;
  {
    const Lock lock(mutex_);
    for (const auto& [name, reader] : readers_) readers.push_back(reader);
    for (const std::weak_ptr<JointReader>& former : former_) readers.push_back(former.lock());
  }
  for (const std::shared_ptr<JointReader>& reader : readers) {
    if (reader != nullptr) reader->forget(participant);
  }
}

}  // namespace sft::core
