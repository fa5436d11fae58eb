// Converts the status of publishers, subscribers and nodes to JSON, for the socket between a peer and its
// test.
#pragma once

#include <sft/sft.h>

#include <nlohmann/json.hpp>

namespace sft::test {

nlohmann::json to_json(const PublisherStatus::Reader& reader);
nlohmann::json to_json(const SubscriberStatus::Writer& writer);
nlohmann::json to_json(const PublisherStatus& status);
nlohmann::json to_json(const SubscriberStatus& status);
nlohmann::json to_json(const NodeStatus& status);
nlohmann::json to_json(const Event& event);

}  // namespace sft::test
