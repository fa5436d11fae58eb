// Finds subscribers whose topic has no publisher, while a topic with a similar name and the same type has
// one: the name may be misspelt, or lack its namespace. Uses no clock, thread or I/O.
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

/// Returns whether a person may have meant the one topic and written the other: few letters differ, or one is
/// the end of the other, as "points" is of "lidar/points". Topics that differ only in their digits, as
/// "camera1" and "camera2", are not similar: both are usual.
bool is_similar_topic(std::string_view a, std::string_view b);

class MisspeltTopics {
 public:
  /// By then, each publisher that exists is known. A topic is looked up again after twice that time, and so
  /// on, because its publisher and that of a similar topic may come later.
  static constexpr std::chrono::seconds first_look{3};

  /// A subscriber of ours was opened.
  void added(EndpointId reader, Time now) { unpublished_[reader] = {now + first_look, first_look}; }
  using PublishersOf = std::function<std::vector<Discovery::KnownPublisher>(const std::string& type_name)>;
  /// Returns a sentence for each subscriber whose topic may be misspelt, and whose next look is due.
  /// `publishers_of`: see Discovery. Once the topic has had a publisher, the subscriber is not looked at
  /// again.
  std::vector<std::string> look(const EndpointTable& table, const PublishersOf& publishers_of, Time now);

 private:
  struct NextLook {
    Time at{};
    std::chrono::seconds pause{};
  };
  std::map<EndpointId, NextLook> unpublished_;  ///< by the reader
};

}  // namespace sft::core
