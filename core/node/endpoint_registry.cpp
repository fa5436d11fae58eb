#include "core/node/endpoint_registry.h"

#include <utility>

namespace sft::core {

namespace {

NodeSnapshot::Publisher snapshot_of(const PublisherCore& publisher) {
  const PublisherCore::Spec& spec = publisher.spec();
  PublisherStatus status = publisher.status();
  NodeSnapshot::Publisher snapshot{.id = spec.id,
                                   .topic = spec.topic,
                                   .type = std::string(spec.type->name()),
                                   .qos = spec.qos,
                                   .fields = spec.type->format_mask(status.mask),
                                   .published = status.published,
                                   .bytes_sent = status.bytes_sent,
                                   .bytes_saved = status.bytes_saved,
                                   .dropped = status.dropped,
                                   .diverted = status.diverted,
                                   .vanilla_readers = status.vanilla_readers,
                                   .deadlines_missed = status.deadlines_missed,
                                   .alive = status.alive,
                                   .readers = {}};
  for (PublisherStatus::Reader& reader : status.readers) {
    // A reader that does not match has no mask.
    std::string fields = reader.mask.leaves() == 0 ? "" : spec.type->format_selection(reader.selection);
    snapshot.readers.push_back({std::move(reader), std::move(fields)});
  }
  return snapshot;
}

NodeSnapshot::Subscriber snapshot_of(SubscriberCore& subscriber, std::size_t selection) {
  const SubscriberCore::Spec& spec = subscriber.spec();
  NodeSnapshot::Subscriber snapshot;
  Feed& feed = subscriber.feed(selection);
  static_cast<SubscriberStatus&>(snapshot) = feed.status();
  snapshot.id = feed.spec().id;
  snapshot.selection_number = selection;
  snapshot.topic = spec.topic;
  snapshot.type = spec.type->name();
  snapshot.qos = feed.spec().qos;
  snapshot.fields = spec.type->format_selection(snapshot.selection);
  snapshot.recorded = subscriber.is_recorded();
  return snapshot;
}

}  // namespace

void EndpointRegistry::enter(const PublisherCore& publisher) {
  const Lock lock(mutex_);
  publishers_.push_back(&publisher);
}

void EndpointRegistry::enter(SubscriberCore& subscriber) {
  const Lock lock(mutex_);
  subscribers_.push_back(&subscriber);
}

void EndpointRegistry::strike_off(const PublisherCore& publisher) {
  const Lock lock(mutex_);
  std::erase(publishers_, &publisher);
}

void EndpointRegistry::strike_off(const SubscriberCore& subscriber) {
  const Lock lock(mutex_);
  std::erase(subscribers_, &subscriber);
}

std::size_t EndpointRegistry::size() {
  const Lock lock(mutex_);
  return publishers_.size() + subscribers_.size();
}

void EndpointRegistry::describe(NodeSnapshot& snapshot) {
  const Lock lock(mutex_);
  for (const PublisherCore* publisher : publishers_) snapshot.publishers.push_back(snapshot_of(*publisher));
  for (SubscriberCore* subscriber : subscribers_) {
    for (std::size_t i = 0; i < subscriber->selections(); ++i)
      snapshot.subscribers.push_back(snapshot_of(*subscriber, i));
  }
}

}  // namespace sft::core
