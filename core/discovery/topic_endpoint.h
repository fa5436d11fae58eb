// Makes readers and writers of Cyclone's.
#pragma once

#include <dds/dds.h>

#include <memory>
#include <string>

#include "sft/result.h"

namespace sft::core {

struct ListenerDeleter {
  void operator()(dds_listener_t* listener) const { dds_delete_listener(listener); }
};
using DdsListener = std::unique_ptr<dds_listener_t, ListenerDeleter>;

struct TopicName {
  const dds_topic_descriptor_t* type = nullptr;
  const char* name = nullptr;
};

/// Makes the topic in that participant, and an endpoint of it by `create(topic)`.
template <class Create>
Result<dds_entity_t> create_on_topic(dds_entity_t participant, const TopicName& name, const dds_qos_t* qos,
                                     Create create) {
  const dds_entity_t topic = dds_create_topic(participant, name.type, name.name, qos, nullptr);
  const dds_entity_t created = topic < 0 ? topic : create(topic);
  if (created >= 0) return created;
  if (topic >= 0) dds_delete(topic);
  return fail(Errc::system, std::string("control topic ") + name.name + ": " + dds_strretcode(created));
}

}  // namespace sft::core
