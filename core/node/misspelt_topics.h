// Finds subscribers whose topic nobody publishes, while a topic of a similar name and of the same type is
// published: the name may be misspelt, or lack its namespace. Pure.
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
/// the end of the other, as "points" is of "lidar/points". Topics that differ only in their digits are
/// meant, as "camera1" and "camera2" are.
bool is_similar_topic(std::string_view a, std::string_view b);

class MisspeltTopics {
 public:
  /// A publisher that is there is known by then. A topic is looked for again after twice that time, and so
  /// on, since its publisher and the one of the similar topic may come later.
  static constexpr std::chrono::seconds first_look{3};

  /// A subscriber of ours was opened.
  void added(EndpointId reader, Time now) { unpublished_[reader] = {now + first_look, first_look}; }
  using PublishersOf = std::function<std::vector<Discovery::KnownPublisher>(const std::string& type_name)>;
  /// Returns a sentence for each subscriber that was found by this look. `publishers_of`: see Discovery. It
  /// is called for subscribers that are looked at. Subscribers of which the topic was published are not
  /// looked at again.
  std::vector<std::string> look(const EndpointTable& table, const PublishersOf& publishers_of, Time now);

 private:
  struct NextLook {
    Time at{};
    std::chrono::seconds pause{};
  };
  std::map<EndpointId, NextLook> unpublished_;  ///< by the reader
};

}  // namespace sft::core
