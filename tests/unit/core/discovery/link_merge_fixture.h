// A LinkMerge, and participants that speak to it by two links.
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "core/discovery/link_merge.h"

namespace sft::core {

class LinkMergeTest : public ::testing::Test {
 protected:
  static constexpr LinkId lan = 1, radio = 2;
  static constexpr NodeId node = 77, other_node = 99;
  // The honest node has a participant on each link; the other two are somebody else's.
  static constexpr Speaker by_lan_anew{lan + 7, 11}, by_lan{lan, 11}, by_radio{radio, 12}, stranger{lan, 13},
      far_stranger{radio, 14};

  static Endpoint endpoint(std::uint64_t revision, const std::string& name = "honest", EndpointId id = 5) {
    Endpoint e;
    e.id = id;
    e.role = Role::reader;
    e.node_id = node;
    e.node = name;
    e.topic = "points";
    e.revision = revision;
    e.request.reader = id;
    e.request.sequence = 1;
    return e;
  }
  static Request request(std::uint64_t sequence, EndpointId reader = 5) {
    Request r;
    r.reader = reader;
    r.sequence = sequence;
    return r;
  }

  void announces(const Speaker& speaker, std::uint64_t revision, const std::string& name = "honest") {
    merge.endpoint_came(speaker, endpoint(revision, name), now);
  }
  void announces_as_another_node(std::uint64_t revision) {
    Endpoint altered = endpoint(revision, "forger");
    altered.node_id = other_node;
    merge.endpoint_came(stranger, altered, now);
  }
  void asks(const Speaker& speaker, std::uint64_t sequence) {
    merge.request_came(speaker, request(sequence), now);
  }
  /// Time passes, in which these say that they live.
  void passes(std::chrono::milliseconds duration, const std::vector<Speaker>& speaking = {}) {
    constexpr std::chrono::milliseconds step{100};
    for (const auto end = now + duration; now < end;) {
      now += step;
      if ((now - start) / step % 6 == 0) {
        for (const Speaker& speaker : speaking)
          merge.assertion_came(speaker, {.node = node, .writers = {}}, now);
      }
      merge.tick(now);
    }
  }

  /// Returns what was told since the last call, without signs of life.
  std::vector<std::string> told() {
    std::vector<std::string> all;
    for (const News& news : merge.take_news()) {
      if (const auto* seen = std::get_if<EndpointSeen>(&news)) {
        all.push_back(seen->endpoint->node + " " + std::to_string(seen->endpoint->revision) + " by " +
                      std::to_string(seen->endpoint->announcer));
        for (const LinkId link : seen->silent) all.back() += ", silent on " + std::to_string(link);
      } else if (const auto* asked = std::get_if<Request>(&news)) {
        all.push_back("request " + std::to_string(asked->sequence) + " by " +
                      std::to_string(asked->announcer));
      } else if (std::holds_alternative<EndpointDeparted>(news)) {
        all.push_back("departed");
      } else if (std::holds_alternative<EndpointLost>(news)) {
        all.push_back("lost");
      } else if (std::holds_alternative<NodeLost>(news)) {
        all.push_back("node lost");
      } else if (const auto* refused = std::get_if<Refused>(&news)) {
        all.push_back("refused: " + refused->why);
      }
    }
    return all;
  }
  std::size_t signs_of_life() {
    std::size_t count = 0;
    for (const News& news : merge.take_news()) count += std::holds_alternative<Assertion>(news) ? 1 : 0;
    return count;
  }

  const Time start{};
  Time now = start + std::chrono::hours(1);
  LinkMerge merge;
};

}  // namespace sft::core
