// Tests when a node has a participant for unmodified nodes of DDS.
#include "core/node/vanilla_access.h"

#include <gmock/gmock.h>

#include <optional>

namespace sft::core {
namespace {

using namespace std::chrono_literals;
using enum NodeOptions::VanillaDds;
using testing::ElementsAre;
using testing::HasSubstr;

class VanillaAccessTest : public testing::Test {
 protected:
  void choose(NodeOptions::VanillaDds choice) {
    VanillaAccess::Setup setup{.choice = choice};
    setup.open = [this](const VanillaPlan&) -> Result<std::shared_ptr<VanillaDomain>> {
      ++openings;
      if (!refusal.empty()) return fail(Errc::unavailable, refusal);
      return std::make_shared<VanillaDomain>(nullptr, 0);
    };
    setup.program_speaks = [this](std::uint32_t) { return program_speaks; };
    access.emplace(std::move(setup), log);
  }
  /// Returns true if there is a participant after a look.
  bool has_domain(bool has_endpoints = true) {
    access->look(heard, has_endpoints, now);
    return access->domain() != nullptr;
  }
  void node_comes() { heard = {true, heard.came + 1}; }
  void last_node_goes() { heard.is_there = false; }

  Discovery::Vanilla heard;
  Time now = Time{} + 1h;
  bool program_speaks = false;
  std::string refusal;
  int openings = 0;
  std::vector<std::string> logged;
  NodeLog log{"node", LogLevel::warning,
              [this](LogLevel, std::string_view text) { logged.emplace_back(text); }};
  std::optional<VanillaAccess> access;
};

TEST_F(VanillaAccessTest, ByItselfItIsThereWhileSuchNodesAreAndAWhileLonger) {
  choose(automatic);
  EXPECT_FALSE(has_domain());
  node_comes();
  EXPECT_TRUE(has_domain());
  EXPECT_TRUE(has_domain());
  EXPECT_EQ(openings, 1);
  last_node_goes();
  now += VanillaAccess::kept - 1s;
  EXPECT_TRUE(has_domain());
  EXPECT_EQ(access->next_look(), now + 1s);
  now += 1s;
  EXPECT_FALSE(has_domain());
  EXPECT_EQ(access->next_look(), Time::max());
}

TEST_F(VanillaAccessTest, ThereIsNoneForANodeWithoutPublishersAndSubscribers) {
  for (const auto choice : {automatic, always}) {
    choose(choice);
    node_comes();
    EXPECT_FALSE(has_domain(false));
    EXPECT_TRUE(has_domain(true));
    EXPECT_FALSE(has_domain(false));
  }
}

TEST_F(VanillaAccessTest, NeverMeansNever) {
  choose(never);
  node_comes();
  EXPECT_FALSE(has_domain());
}

TEST_F(VanillaAccessTest, AProgramThatSpeaksDdsItselfHasNoneUnlessItSaysSo) {
  program_speaks = true;
  choose(automatic);
  node_comes();
  EXPECT_FALSE(has_domain());
  choose(always);
  EXPECT_TRUE(has_domain());
}

TEST_F(VanillaAccessTest, AProgramThatBeginsToSpeakDdsLosesIt) {
  choose(automatic);
  node_comes();
  EXPECT_TRUE(has_domain());
  program_speaks = true;
  node_comes();  // this participant is the program's own
  EXPECT_FALSE(has_domain());
}

TEST_F(VanillaAccessTest, WhatCannotBeOpenedIsTriedAgainAfterAPauseAndNamedOnce) {
  refusal = "no interface";
  choose(always);
  EXPECT_FALSE(has_domain());
  EXPECT_FALSE(has_domain());
  EXPECT_EQ(openings, 1);
  now = access->next_look();
  EXPECT_FALSE(has_domain());
  EXPECT_EQ(openings, 2);
  EXPECT_THAT(logged, ElementsAre(HasSubstr("no interface")));
  refusal.clear();
  now = access->next_look();
  EXPECT_TRUE(has_domain());
}

}  // namespace
}  // namespace sft::core
