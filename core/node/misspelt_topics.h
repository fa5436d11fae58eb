// Finds subscribers whose topic has no publisher, while a topic with a similar name and the same type has a
// publisher. Then the subscriber's topic may be misspelt, or lack its namespace. Uses no clock, thread or
// I/O.
#pragma once

#include <chrono>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "core/discovery/discovery.h"
#include "core/negotiation/endpoint_table.h"
#include "core/platform/clock.h"

namespace sft::core {

/// Returns true if a person may have meant one of the topics and written the other. This is so if few
/// letters differ, or if one topic is the end of the other, as in "points" and "lidar/points". Topics that
/// differ only in their digits, such as "camera1" and "camera2", are not similar, because such names are
/// common.
bool is_similar_topic(std::string_view a, std::string_view b);

class MisspeltTopics {
 public:
  /// The time until the first look, after which each existing publisher is known. Each further look is due
  /// after twice the time of the previous one, because the publisher of the topic, or that of a similar
  /// topic, may start later.
  static constexpr std::chrono::seconds first_look{3};

  /// Called when a subscriber of this node was opened.
  void added(EndpointId reader, Time now) { unpublished_[reader] = {now + first_look, first_look}; }
  using PublishersOf = std::function<std::vector<Discovery::KnownPublisher>(const std::string& type_name)>;
  /// Returns a sentence for each subscriber whose next look is due and whose topic may be misspelt.
  /// `publishers_of` returns the publishers of that type, also those of DDS. Once the topic has had a
  /// publisher, its subscriber is not examined again.
  std::vector<std::string> look(const EndpointTable& table, const PublishersOf& publishers_of, Time now);

 private:
  struct NextLook {
    Time at{};
    std::chrono::seconds pause{};
  };
  std::map<EndpointId, NextLook> unpublished_;  ///< by the id of the reader
};

}  // namespace sft::core
