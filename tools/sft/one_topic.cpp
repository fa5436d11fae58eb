#include "tools/sft/one_topic.h"

#include <algorithm>
#include <chrono>
#include <iterator>
#include <optional>

#include "tools/sft/describe.h"

namespace sft::tool {

using namespace std::chrono_literals;

OneTopic part_of(const DomainSnapshot& domain, const std::string& topic) {
  OneTopic part{.name = topic, .publishers = {}, .subscribers = {}, .pairs = {}};
  const auto is_meant = [&](const DomainSnapshot::Endpoint& e) { return e.topic == topic; };
  std::ranges::copy_if(domain.publishers, std::back_inserter(part.publishers), is_meant);
  std::ranges::copy_if(domain.subscribers, std::back_inserter(part.subscribers), is_meant);
  std::ranges::copy_if(domain.pairs, std::back_inserter(part.pairs), [&](const DomainSnapshot::Pair& pair) {
    return endpoint_of(pair.publisher, part.publishers) != nullptr;
  });
  return part;
}

Result<OneTopic> look_at(std::string_view topic, const CommonOptions& common, Session& session) {
  if (const Result<void> sound = session.check_name(topic); !sound) return tl::unexpected(sound.error());
  std::optional<std::string> name;
  const auto is_known = [&](const DomainSnapshot& domain) {
    name = Session::known_name(topic, domain);
    return name.has_value();
  };
  const bool found = session.wait_until(is_known);
  if (found) session.stop().wait_for(seconds(common.wait_s));
  name = Session::known_name(topic, session.domain());
  if (name) return part_of(session.domain(), *name);
  // The library's error names the topics that it knows.
  const Result<DynamicType> type = session.node().find_type(topic, 0s);
  if (type) return fail(Errc::unavailable, "the topic was withdrawn meanwhile");
  return tl::unexpected(session.explained(type.error(), topic));
}

}  // namespace sft::tool
