// The part of a domain's snapshot that concerns one topic.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "tools/sft/session.h"

namespace sft::tool {

struct OneTopic {
  std::string name;
  std::vector<DomainSnapshot::Endpoint> publishers;
  std::vector<DomainSnapshot::Endpoint> subscribers;
  std::vector<DomainSnapshot::Pair> pairs;
};

/// Waits until a node uses the topic, and then collects further nodes for common.wait_s. The error is
/// Errc::unavailable if no node uses the topic within the timeout.
Result<OneTopic> look_at(std::string_view topic, const CommonOptions& common, Session& session);

OneTopic part_of(const DomainSnapshot& domain, const std::string& topic);

}  // namespace sft::tool
