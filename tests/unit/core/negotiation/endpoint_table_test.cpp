// Tests of the table of endpoints: its contents, and that nothing remains of an endpoint that has departed.
#include "core/negotiation/endpoint_table.h"

#include <gmock/gmock.h>

#include <sensor_msgs/msg/PointCloud2.hpp>

#include "core/negotiation/known_facts.h"

namespace sft::core {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::Pair;

constexpr EndpointId our_writer = 100, one_reader = 5, other_reader = 6;
constexpr NodeId its_node = 77;

Endpoint endpoint(Role role, EndpointId id, const std::string& topic = "points") {
  Endpoint e;
  e.id = id;
  e.role = role;
  e.topic = topic;
  e.node = "theirs";
  e.node_id = its_node;
  e.announcer = 11;
  return e;
}

class EndpointTableTest : public ::testing::Test {
 protected:
  EndpointTableTest() { table.add_ours(endpoint(Role::writer, our_writer), type); }

  std::vector<EndpointId> readers_of_our_writer() const {
    std::vector<EndpointId> ids;
    for (const TableEntry* entry : table.counterparts(*table.find(our_writer)))
      ids.push_back(entry->endpoint.id);
    return ids;
  }

  const TypeSupport type{detail::TypeTable<sensor_msgs::msg::PointCloud2>::type};
  const Time now{1h};
  EndpointTable table{{.entries = 2}};
};

TEST_F(EndpointTableTest, CounterpartsAreOfTheSameTopicAndTheOtherRole) {
  table.enter(endpoint(Role::reader, one_reader));
  table.enter(endpoint(Role::writer, other_reader));
  EXPECT_THAT(readers_of_our_writer(), ElementsAre(one_reader));
  table.enter(endpoint(Role::reader, one_reader, "another topic"));
  EXPECT_THAT(readers_of_our_writer(), IsEmpty());
}

TEST_F(EndpointTableTest, OnlyOurEndpointsAreFoundAsOurs) {
  table.enter(endpoint(Role::reader, one_reader));
  EXPECT_NE(table.find_ours(our_writer), nullptr);
  EXPECT_NE(table.find(one_reader), nullptr);
  EXPECT_EQ(table.find_ours(one_reader), nullptr);
}

TEST_F(EndpointTableTest, WhatWasKnownOfAnEndpointIsReturnedWhenItIsReplaced) {
  EXPECT_FALSE(table.enter(endpoint(Role::reader, one_reader)));
  EXPECT_EQ(table.enter(endpoint(Role::reader, one_reader, "another topic"))->topic, "points");
}

TEST_F(EndpointTableTest, ALostEndpointIsNotPresentUntilItIsSeenAgain) {
  table.enter(endpoint(Role::reader, one_reader));
  EXPECT_TRUE(table.lost(one_reader, now));
  EXPECT_FALSE(table.lost(one_reader, now));
  EXPECT_TRUE(table.misses_peer());
  EXPECT_EQ(table.present().size(), 1U);
  EXPECT_THAT(table.lost_for(60s, now + 59s), IsEmpty());
  EXPECT_THAT(table.lost_for(60s, now + 60s), ElementsAre(one_reader));
  table.enter(endpoint(Role::reader, one_reader));
  EXPECT_FALSE(table.misses_peer());
}

TEST_F(EndpointTableTest, OurEndpointsAreNeverLost) { EXPECT_FALSE(table.lost(our_writer, now)); }

TEST_F(EndpointTableTest, ALostEndpointThatIsErasedIsNotMissed) {
  table.enter(endpoint(Role::reader, one_reader));
  table.lost(one_reader, now);
  EXPECT_TRUE(table.misses_peer());
  table.erase(one_reader);
  EXPECT_FALSE(table.misses_peer());
}

TEST_F(EndpointTableTest, OnlyTopicsOfOurEndpointsAreOurs) {
  table.enter(endpoint(Role::reader, one_reader, "another topic"));
  EXPECT_TRUE(table.is_topic_of_ours("points"));
  EXPECT_FALSE(table.is_topic_of_ours("another topic"));
  EXPECT_FALSE(table.is_topic_of_ours("a topic of nobody"));
  table.enter(endpoint(Role::reader, other_reader));
  table.erase(our_writer);
  EXPECT_FALSE(table.is_topic_of_ours("points")) << "only endpoints of other nodes are left there";
}

TEST_F(EndpointTableTest, OnlyWritersHaveProgress) {
  table.enter(endpoint(Role::writer, 7));
  EXPECT_EQ(table.progress_of(7), nullptr);
  for (const EndpointId id : {7, 8}) table.progressed({.writer = id, .samples = 3});
  EXPECT_EQ(table.progress_of(7)->samples, 3U);
  table.enter(endpoint(Role::reader, 9));
  table.progressed({.writer = 9, .samples = 3});
  EXPECT_EQ(table.progress_of(9), nullptr);
}

TEST_F(EndpointTableTest, ANewcomerThatIsRefusedIsCountedByTheNameOfItsNode) {
  for (EndpointId id = 5; id <= 7; ++id) {
    if (table.admit(endpoint(Role::reader, id)).granted) table.enter(endpoint(Role::reader, id));
  }
  EXPECT_EQ(table.size(), 3U) << "with our own";
  EXPECT_EQ(table.refused(), 1U);
  EXPECT_EQ(table.take_refusals().at("theirs"), 1U);
  EXPECT_THAT(table.take_refusals(), IsEmpty());
}

TEST_F(EndpointTableTest, AnEndpointThatHasToLeaveIsCountedByTheNameOfItsNode) {
  for (const EndpointId id : {one_reader, other_reader}) table.enter(endpoint(Role::reader, id));
  Endpoint newcomer = endpoint(Role::reader, 7);
  newcomer.announcer = 12;
  newcomer.node = "another";
  EXPECT_EQ(table.admit(newcomer).instead_of, other_reader);
  EXPECT_THAT(table.take_refusals(), ElementsAre(Pair("theirs", 1U)));
}

TEST(DescriptionsInTheTable, ThatOneParticipantSendsAreKeptUpToABoundAndItsEndpointsAllTheSame) {
  EndpointTable table{{}};
  constexpr std::size_t bytes = 65'536, most = DescriptionRoom::description_bytes_of_announcer / bytes;
  const auto enter = [&](EndpointId id, AnnouncerId announcer) {
    Endpoint described = endpoint(Role::writer, id);
    described.announcer = announcer;
    described.type_description.resize(bytes);
    table.enter(described);
    return !table.known(id)->type_description.empty();
  };
  for (EndpointId id = 1; id <= most; ++id) EXPECT_TRUE(enter(id, 11));
  EXPECT_FALSE(enter(most + 1, 11));
  EXPECT_TRUE(enter(1, 11)) << "it replaces its own";
  EXPECT_TRUE(enter(most + 2, 12)) << "another one has its own room";
  table.erase(2);
  EXPECT_TRUE(enter(most + 1, 11));
  std::size_t kept = 0;
  for (EndpointId id = 1000; id < 2000; ++id) kept += enter(id, id / 100) ? 1 : 0;
  EXPECT_EQ(kept, DescriptionRoom::description_bytes_max / bytes - most - 1) << "all together";
}

TEST(KnownFactsTest, NothingRemainsNotedOfAnEndpointThatIsGone) {
  KnownFacts facts{.host = {}, .table = EndpointTable({}), .history = {}, .unreachable = {}};
  Endpoint gone = endpoint(Role::reader, one_reader);
  gone.request.begun = {our_writer};
  facts.table.enter(gone);
  EXPECT_TRUE(facts.history.given(our_writer, gone));
  EXPECT_TRUE(facts.unreachable.changed({our_writer, one_reader}, "no doorbell"));
  facts.erase(one_reader);
  EXPECT_EQ(facts.table.known(one_reader), nullptr);
  EXPECT_TRUE(facts.history.given(our_writer, gone)) << "it counts as new";
  EXPECT_EQ(facts.unreachable.why({our_writer, one_reader}), nullptr);
}

TEST(UnreachableReadersTest, OnlyAnotherReasonIsNews) {
  UnreachableReaders unreachable;
  EXPECT_TRUE(unreachable.changed({our_writer, one_reader}, "no doorbell"));
  EXPECT_FALSE(unreachable.changed({our_writer, one_reader}, "no doorbell"));
  EXPECT_EQ(*unreachable.why({our_writer, one_reader}), "no doorbell");
  EXPECT_TRUE(unreachable.changed({our_writer, one_reader}, ""));
  EXPECT_FALSE(unreachable.changed({our_writer, one_reader}, ""));
}

}  // namespace
}  // namespace sft::core
