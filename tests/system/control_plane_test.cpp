// Processes on an isolated host find each other by records.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/discovery/discovery.h"
#include "tests/support/eventually.h"
#include "tests/support/isolated_host.h"
#include "tests/system/control_reader.h"

namespace sft::test {
namespace {

using core::Role;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

/// The discovery of a node, which announces records and finds those of other nodes.
class Node {
 public:
  explicit Node(const std::string& process, const std::string& cyclone_config = "")
      : reader_(process, cyclone_config) {}
  ControlReader* operator->() { return &reader_; }

 private:
  ControlReader reader_;
};

class ControlPlaneNodes : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!isolation_refusal().empty()) GTEST_SKIP() << isolation_refusal();
  }
  static bool look_until(const std::vector<Node*>& nodes, const std::function<bool()>& is_so) {
    return eventually([&] {
      for (Node* const node : nodes) (*node)->look();
      return is_so();
    });
  }
};

TEST_F(ControlPlaneNodes, ReadersHearOfWritersOnlyAndWritersOfReadersUntilTheyAreToldToHearMore) {
  Node reader("a"), other_reader("b"), writer("c");
  reader->announce(Role::reader, 1);
  other_reader->announce(Role::reader, 2);
  writer->announce(Role::writer, 3);
  EXPECT_TRUE(writer->hears(1) && writer->hears(2));
  EXPECT_TRUE(reader->hears(3) && other_reader->hears(3));
  EXPECT_THAT(reader->heard(), ElementsAre(3));
  reader->hear(Role::reader);
  EXPECT_TRUE(reader->hears(2)) << "though it was announced before";
}

TEST_F(ControlPlaneNodes, AWriterThatComesLateHearsTheLatestRequestOfEachReader) {
  Node reader("a"), writer("b");
  reader->announce(Role::reader, 1);
  for (std::uint64_t sequence = 1; sequence < 10; ++sequence) reader->ask(1, sequence);
  writer->announce(Role::writer, 2);
  EXPECT_TRUE(eventually([&] { return writer->asked() == 9; }));
}

TEST_F(ControlPlaneNodes, HearOfWhatIsWithdrawnAndOfWhatHasTheSlotThen) {
  Node reader("a"), writer("b");
  reader->announce(Role::reader, 1);
  for (core::EndpointId id = 100; id < 120; ++id) {
    writer->announce(Role::writer, id);
    EXPECT_TRUE(reader->hears(id)) << id;
    writer->withdraw(id);
    EXPECT_TRUE(eventually([&] { return reader->heard().empty(); })) << id;
  }
}

TEST_F(ControlPlaneNodes, OfOneProcessHearEachOther) {
  Node one("a"), two("a");
  one->announce(Role::writer, 1);
  two->announce(Role::reader, 2);
  EXPECT_TRUE(one->hears(2) && two->hears(1));
  two->ask(2, 7);
  EXPECT_TRUE(eventually([&] { return one->asked() == 7; }));
}

TEST_F(ControlPlaneNodes, HearOfTheEndOfAProcess) {
  Node reader("a");
  reader->announce(Role::reader, 1);
  {
    Node writer("b");
    writer->announce(Role::writer, 2);
    EXPECT_TRUE(reader->hears(2));
  }
  EXPECT_TRUE(eventually([&] { return reader->gone() == 1; }));
}

TEST_F(ControlPlaneNodes, ThatOnlyGoOnLivingHearNothingNewAndMakeNoLinkAnew) {
  Node reader("a"), writer("b");
  reader->announce(Role::reader, 1);
  writer->announce(Role::writer, 2);
  EXPECT_TRUE(reader->hears(2) && writer->hears(1));
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(15);
  EXPECT_TRUE(look_until({&reader, &writer}, [&] { return std::chrono::steady_clock::now() > end; }));
  EXPECT_EQ(reader->gone() + writer->gone(), 0u);
  EXPECT_THAT(reader->renewals(), IsEmpty());
}

/// Heartbeats are sent by the topic if certificates or the user's configuration rule out heartbeats by UDP.
TEST_F(ControlPlaneNodes, WhoseHeartbeatsGoByTheTopicHearThoseWhoseHeartbeatsGoByUdp) {
  Node reader("a"), writer("b", "<General><MulticastTimeToLive>8</MulticastTimeToLive></General>");
  reader->announce(Role::reader, 1);
  writer->announce(Role::writer, 2);
  EXPECT_TRUE(reader->hears(2) && writer->hears(1));
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(15);
  EXPECT_TRUE(look_until({&reader, &writer}, [&] { return std::chrono::steady_clock::now() > end; }));
  EXPECT_EQ(reader->gone() + writer->gone(), 0u);
}

TEST_F(ControlPlaneNodes, CarryTwoHundredNodesInOneProcess) {
  std::vector<std::unique_ptr<Node>> nodes;
  for (core::EndpointId id = 1; id <= 200; ++id) {
    nodes.push_back(std::make_unique<Node>("a"));
    (*nodes.back())->announce(Role::reader, id);
  }
  Node writer("b");
  writer->announce(Role::writer, 1000);
  EXPECT_TRUE(eventually([&] { return writer->heard().size() == 200; }));
  for (const auto& node : nodes) EXPECT_TRUE((*node)->hears(1000));
}

}  // namespace
}  // namespace sft::test
