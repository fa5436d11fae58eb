// Tests of the table of endpoints.
#include "core/negotiation/endpoint_table.h"

#include <gmock/gmock.h>

#include <sensor_msgs/msg/PointCloud2.hpp>

namespace sft::core {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr EndpointId our_writer = 100, one_reader = 5, other_reader = 6;
constexpr NodeId its_node = 77;

Endpoint endpoint(Role role, EndpointId id, const std::string& topic = "points") {
  Endpoint e;
  e.id = id;
  e.role = role;
  e.topic = topic;
  e.node = "theirs";
  e.node_id = its_node;
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
  EndpointTable table;
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
  EXPECT_FALSE(table.find(7)->progress);
  for (const EndpointId id : {7, 8}) table.progressed({.writer = id, .samples = 3});
  EXPECT_EQ(table.find(7)->progress->samples, 3U);
  table.enter(endpoint(Role::reader, 9));
  table.progressed({.writer = 9, .samples = 3});
  EXPECT_FALSE(table.find(9)->progress);
}

}  // namespace
}  // namespace sft::core
