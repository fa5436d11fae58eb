// Two ears hear the same of a crowd. One of them lets pulses wait that say nothing new; the other one never
// does. Both tell the same at the same time, apart from signs of life that others have given before.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <memory>
#include <random>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "core/discovery/discovery_ear.h"
#include "core/discovery/life_signs.h"
#include "tests/support/test_seed.h"
#include "tests/unit/core/discovery/other_process.h"

namespace sft::core {
namespace {

using namespace test;
using std::chrono::milliseconds;

constexpr unsigned signs_for_each_full_one = full_sign_pause / life_signs_by_pulses.pause_in_calm;

/// What a node is told. That another node lives counts again once anything else was told of it; a full sign,
/// which tells more than life, always counts.
struct Told final : DiscoveryListener {
  void endpoint_seen(Endpoint endpoint) override { add("seen", node_of_writer(endpoint.id)); }
  void endpoint_departed(EndpointId id) override { add("departed", node_of_writer(id)); }
  void endpoint_lost(EndpointId id) override { add("lost", node_of_writer(id)); }
  void request_received(Request request) override { add("request", request.reader); }
  void liveliness_asserted(Assertion sign) override {
    ++signs[sign.node];
    const bool is_first = living.insert(sign.node).second;
    if (!sign.progress.empty()) log.push_back("progress " + std::to_string(sign.progress.front().samples));
    if (is_first) log.push_back("lives " + std::to_string(sign.node));
  }
  void node_lost(NodeId id) override { add("node lost", id); }
  void control_malformed(std::string why) override { log.push_back(std::move(why)); }
  void add(const char* what, NodeId node) {
    log.push_back(what + (" " + std::to_string(node)));
    living.erase(node);
  }

  std::vector<std::string> log;
  std::set<NodeId> living;
  std::map<NodeId, std::size_t> signs;  ///< how many were told
};

Time now_of_crowd{1000s};

/// An ear, and a node of its process that has a reader.
struct Listening {
  Listening() {
    ear.link_expected(lan_of_others, true);
    ear.hears(Role::writer, now_of_crowd);
    ear.with_nodes([&](ProcessNodes& nodes, const auto&) { nodes.join(member); });
    announces_reader(1, "wanted");
  }

  void announces_reader(EndpointId id, const std::string& topic) {
    ear.with_nodes([&](ProcessNodes& nodes, LinkMerge& merge) {
      Endpoint reader;
      reader.id = id;
      reader.role = Role::reader;
      reader.topic = topic;
      merge.owns(reader.id);
      nodes.announced(member, reader, merge.endpoints());
    });
    ear.pass_on();
  }

  Told told;
  const std::shared_ptr<NodeListener> member = std::make_shared<NodeListener>(told);
  DiscoveryEar ear{life_signs_by_pulses, [] { return now_of_crowd; }};
};

class EarsOfACrowd : public ::sft::test::RandomTest {
 protected:
  EarsOfACrowd() {
    for (int i = 0; i < 24; ++i) comes();
  }

  bool happens(double share) { return std::uniform_real_distribution<>(0, 1)(random) < share; }
  template <class Tell>
  void both(Tell tell) {
    tell(letting_wait.ear);
    never_waiting.ear.with_nodes([](auto&, auto&) {});  // something else happens
    tell(never_waiting.ear);
  }
  void comes() {
    OtherProcess& other = others.emplace_back(participants, static_cast<std::uint8_t>(others.size() + 1));
    other.signs = static_cast<unsigned>(random() % signs_for_each_full_one);
    both([&](DiscoveryEar& ear) { ear.participant_came(other.speaker); });
    both([&](DiscoveryEar& ear) { ear.participant_speaks(other.speaker); });
    announces(other);
    gives_sign(other, true);
  }
  void announces(OtherProcess& other) {
    ++other.writer.revision;
    both([&](DiscoveryEar& ear) { ear.endpoint_came(other.speaker, other.writer); });
  }
  /// A pulse, which is heard at the next look, and maybe a full sign, which is heard before.
  void gives_sign(OtherProcess& other, bool is_full) {
    other.sent = other.pulse();
    if (!is_full) return;
    const Assertion sign = other.full_sign();
    if (happens(lost_share)) return;
    both([&](DiscoveryEar& ear) { ear.assertion_came(other.speaker, sign, full_sign_lease); });
  }
  void departs(OtherProcess& other) {
    other.is_dead = true;
    both([&](DiscoveryEar& ear) { ear.endpoint_withdrawn(other.speaker, other.writer.id); });
    both([&](DiscoveryEar& ear) { ear.participant_departed(other.speaker); });
  }

  /// What both find at a look.
  void look() {
    const Time since = std::exchange(looked, now_of_crowd);
    for (const OtherProcess& other : others) {
      if (other.is_dead || happens(lost_share)) continue;
      both([&](DiscoveryEar& ear) { ear.pulse_came(lan_of_others, other.sent, participants, since); });
    }
    std::vector<std::tuple<bool, bool, std::size_t>> found;
    both([&](DiscoveryEar& ear) {
      ear.pulses_heard(now_of_crowd);
      const DiscoveryEar::Deafness deafness = ear.look_for_deafness(20s, now_of_crowd);
      const SignPace signs = ear.tick(now_of_crowd).signs;
      ear.pass_on();
      found.push_back({signs.wants(now_of_crowd), signs.is_calm(now_of_crowd), deafness.renewals.size()});
    });
    ASSERT_EQ(found[0], found[1]) << "what is wanted and calm, and the links that are deaf";
    ASSERT_EQ(letting_wait.told.log, never_waiting.told.log);
    for (const auto& [node, signs] : letting_wait.told.signs)
      ASSERT_LE(signs, never_waiting.told.signs[node]) << "no sign of node " << node << " is made up";
  }
  /// All that may happen between two looks.
  void live(double share_of_events) {
    for (OtherProcess& other : others) {
      if (other.is_dead) continue;
      now_of_crowd += milliseconds(random() % 10);
      gives_sign(other, ++other.signs % signs_for_each_full_one == 0);
      if (happens(share_of_events)) announces(other);
      if (happens(share_of_events / 4)) departs(other);
      if (happens(share_of_events / 4)) other.is_dead = true;  // killed
    }
    if (others.size() < 200 && happens(share_of_events)) comes();
    now_of_crowd = std::max(now_of_crowd, looked + milliseconds(900 + random() % 60));
  }

  double lost_share = 0;
  Participants participants;
  Listening letting_wait, never_waiting;
  std::vector<OtherProcess> others;
  Time looked = now_of_crowd;
};

TEST_F(EarsOfACrowd, TellTheSameInCalm) {
  for (int second = 0; second < 300 && !HasFatalFailure(); ++second) {
    live(0);
    look();
  }
}

TEST_F(EarsOfACrowd, TellRepeatedSignsOnlyWhereEachOneIsAwaited) {
  for (int second = 0; second < 30 && !HasFatalFailure(); ++second) {
    live(0);
    look();
  }
  const auto signs_told = [&] {
    letting_wait.told.log.clear();
    letting_wait.told.living.clear();
    for (const OtherProcess& other : others)
      letting_wait.ear.pulse_came(lan_of_others, other.sent, participants, looked);
    letting_wait.ear.pass_on();
    return letting_wait.told.log.size();
  };
  EXPECT_EQ(signs_told(), 0U);
  letting_wait.ear.tell_every_pulse();
  const auto has_wanted_writer = [](const OtherProcess& other) { return other.writer.topic == "wanted"; };
  EXPECT_EQ(signs_told(), static_cast<std::size_t>(std::ranges::count_if(others, has_wanted_writer)));
}

TEST_F(EarsOfACrowd, TellANodeThatBeginsToHearATopicWhoLives) {
  for (int second = 0; second < 30 && !HasFatalFailure(); ++second) {
    live(0);
    look();
  }
  for (Listening* const listening : {&letting_wait, &never_waiting})
    listening->announces_reader(2, "unwanted");
  live(0);
  look();
  for (const OtherProcess& other : others) EXPECT_TRUE(letting_wait.told.living.contains(other.node));
}

TEST_F(EarsOfACrowd, TellTheSameWhereNodesComeGoAndAreKilled) {
  for (int second = 0; second < 2000 && !HasFatalFailure(); ++second) {
    live(second / 100 % 2 == 0 ? 0.002 : 0);
    look();
  }
}

TEST_F(EarsOfACrowd, TellTheSameWhereSignsGetLost) {
  lost_share = 0.02;
  for (int second = 0; second < 2000 && !HasFatalFailure(); ++second) {
    live(0.0005);
    look();
  }
}

}  // namespace
}  // namespace sft::core
