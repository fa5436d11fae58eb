#include "core/discovery/joint_reader.h"

#include <algorithm>
#include <memory>
#include <optional>

namespace sft::core {

Result<void> JointReader::join(const std::shared_ptr<Hearer>& hearer) {
  const Lock joining(joining_);
  {
    Lock lock(mutex_);
    if (std::ranges::find(*hearers_, hearer) != hearers_->end()) return {};
    auto more = std::make_shared<Hearers>(*hearers_);
    more->push_back(hearer);
    hearers_ = std::move(more);
    if (host_ != nullptr) {
      const auto newcomer = std::make_shared<const Hearers>(1, hearer);
      std::vector<Message> messages;
      for (KeptWords::Word& word : kept_.all()) messages.push_back({std::move(word), newcomer});
      pass_on(lock, std::move(messages));
      return {};
    }
  }
  Result<void> hosted = host(hearer);
  if (!hosted) remove(hearer);
  return hosted;
}

void JointReader::leave(const std::shared_ptr<Hearer>& hearer) {
  const Lock joining(joining_);
  remove(hearer);
  if (host_ != hearer) return;
  const dds_entity_t former = reader_;
  host_.reset();
  std::shared_ptr<const Hearers> others;
  {
    const Lock lock(mutex_);
    others = hearers_;
  }
  for (const std::shared_ptr<Hearer>& other : *others) {
    if (host(other)) break;
  }
  dds_delete(former);
  if (host_ != nullptr) return;
  const Lock lock(mutex_);
  kept_.clear();
  takes_newcomers_ = true;
}

void JointReader::forget(const Participants::Guid& participant) {
  const Lock lock(mutex_);
  remotes_.forget_writers_of(participant);
  kept_.forget(participant);
}

Result<void> JointReader::host(const std::shared_ptr<Hearer>& hearer) {
  const DdsListener listener(dds_create_listener(this));
  dds_lset_data_available(listener.get(), &on_data);
  dds_lset_subscription_matched(listener.get(), &on_matched);
  dds_entity_t made = dds_create_topic(hearer->participant(), kind_.type, kind_.name, qos_.get(), nullptr);
  if (made >= 0)
    made = dds_create_reader(hearer->participant(), made, hearing_qos(qos_.get()).get(), listener.get());
  if (made < 0)
    return fail(Errc::system, std::string("control topic ") + kind_.name + ": " + dds_strretcode(made));
  host_ = hearer;
  reader_ = made;
  return {};
}

void JointReader::remove(const std::shared_ptr<Hearer>& hearer) {
  const Lock lock(mutex_);
  auto fewer = std::make_shared<Hearers>(*hearers_);
  std::erase(*fewer, hearer);
  hearers_ = std::move(fewer);
}

void JointReader::pass_on(Lock& lock, std::vector<Message> messages) {
  delivery_.deliver(lock, std::move(messages), [](const Message& message) {
    for (const std::shared_ptr<Hearer>& hearer : *message.to) hearer->hear(*message.word);
  });
}

void JointReader::learn(Lock& lock, ControlWords words) {
  std::vector<Message> messages;
  for (ControlWord& said : words) {
    const auto word = std::make_shared<const ControlWord>(std::move(said));
    kept_.learn(word);
    messages.push_back({word, hearers_});
  }
  takes_newcomers_ = kept_.are_complete();
  pass_on(lock, std::move(messages));
}

void JointReader::on_data(dds_entity_t reader, void* self) {
  JointReader& joint = *static_cast<JointReader*>(self);
  Lock lock(joint.mutex_);
  joint.learn(lock, joint.kind_.take(reader, joint.remotes_));
}

void JointReader::on_matched(dds_entity_t reader, const dds_subscription_matched_status_t status,
                             void* self) {
  JointReader& joint = *static_cast<JointReader*>(self);
  const bool has_come = status.current_count_change > 0;
  std::optional<Participants::Guid> participant;
  if (has_come) participant = publishing_participant(reader, status.last_publication_handle);
  Lock lock(joint.mutex_);
  ControlWords words;
  if (has_come) {
    if (participant) joint.remotes_.matched(status.last_publication_handle, *participant);
  } else {
    participant = joint.remotes_.unmatched(status.last_publication_handle);
  }
  if (!participant) return;
  ControlWord& word = words.emplace_back(participant, EndpointMet{});
  if (!has_come) word.what = EndpointGone{};
  joint.learn(lock, std::move(words));
}

std::shared_ptr<JointReader> JointReaders::of(const JointReader::Kind& kind, const dds_qos_t* qos) {
  const Lock lock(mutex_);
  std::shared_ptr<JointReader>& reader = readers_[kind.name];
  if (reader == nullptr || !reader->takes_newcomers()) reader = std::make_shared<JointReader>(kind, qos);
  return reader;
}

void JointReaders::forget(const Participants::Guid& participant) {
  std::vector<std::shared_ptr<JointReader>> readers;
  {
    const Lock lock(mutex_);
    for (const auto& [name, reader] : readers_) readers.push_back(reader);
  }
  for (const std::shared_ptr<JointReader>& reader : readers) reader->forget(participant);
}

}  // namespace sft::core
