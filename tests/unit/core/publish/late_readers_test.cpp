// Tests which of the earlier samples late readers get.
#include "core/publish/late_readers.h"

#include <gtest/gtest.h>

#include <sensor_msgs/msg/PointCloud2.hpp>

#include "tests/unit/core/publish/port_logs.h"

namespace sft::core::test {
namespace {

using namespace detail;

using sensor_msgs::msg::PointCloud2;
using Calls = std::vector<std::string>;

/// A publisher that has published four samples and retains three of them.
class LateReadersTest : public ::testing::Test {
 protected:
  LateReadersTest() {
    for (std::uint64_t sequence = 1; sequence <= 4; ++sequence)
      history.add(make_sample(*pool, type, sequence));
  }
  Serving late_by_network(std::uint32_t count, std::uint16_t port = 5000) const {
    Serving serving;
    serving.network = {network_route(1, type)};
    serving.network[0].destination = UdpAddress{0x7f000001, port};
    serving.network[0].history = count;
    return serving;
  }
  Serving late_in_memory(std::uint32_t count) const {
    Serving serving;
    serving.memory = {memory_route(1, type)};
    serving.memory[0].history = count;
    return serving;
  }
  std::vector<std::uint64_t> given() const {
    std::vector<std::uint64_t> sequences;
    for (const SampleHandle& sample : memory->given.value()) sequences.push_back(sample->sequence);
    return sequences;
  }
  using Sequences = std::vector<std::uint64_t>;

  const TypeSupport type{TypeTable<PointCloud2>::type};
  const std::shared_ptr<BufferPool> pool = BufferPool::make(1 << 20);
  const std::shared_ptr<NetworkLog> network = std::make_shared<NetworkLog>();
  const std::shared_ptr<MemoryLog> memory = std::make_shared<MemoryLog>();
  const std::shared_ptr<DeliveryBook> book = std::make_shared<DeliveryBook>();
  History history{3, 0};
  LateReaders late{type, network, book, &history};
};

TEST_F(LateReadersTest, AreSentWhatTheyAskForOverTheNetworkOnce) {
  late.serve(late_by_network(2), nullptr);
  EXPECT_EQ(network->take(), (Calls{"history of 2 to 1"}));
  late.serve(late_by_network(2), nullptr);
  EXPECT_EQ(network->take(), Calls{});
  EXPECT_EQ(book->of(1).retained, 2U);
}

TEST_F(LateReadersTest, AreSentItAgainWhereTheyHaveMoved) {
  late.serve(late_by_network(2), nullptr);
  late.serve(late_by_network(2, 6000), nullptr);
  EXPECT_EQ(network->take(), (Calls{"history of 2 to 1", "history of 2 to 1"}));
}

TEST_F(LateReadersTest, AreSentItAgainWhenTheyReturn) {
  late.serve(late_by_network(2), nullptr);
  late.serve({}, nullptr);
  late.serve(late_by_network(2), nullptr);
  EXPECT_EQ(network->take(), (Calls{"history of 2 to 1", "history of 2 to 1"}));
}

TEST_F(LateReadersTest, AreSentNoMoreThanIsRetained) {
  late.serve(late_by_network(100), nullptr);
  EXPECT_EQ(network->take(), (Calls{"history of 3 to 1"}));
  EXPECT_EQ(book->of(1).retained, 3U);
}

TEST_F(LateReadersTest, AreGivenTheRetainedSamplesThatFulfilTheirConditions) {
  Serving serving = late_in_memory(3);
  serving.memory[0].selection = type.parse_selection("* @ every 2nd").value();
  late.serve(serving, memory);
  EXPECT_EQ(given(), (Sequences{2, 4}));
  EXPECT_EQ(book->of(1).retained, 2U);
  serving = late_by_network(3);
  serving.network[0].selection = type.parse_selection("* @ every 2nd").value();
  late.serve(serving, nullptr);
  EXPECT_EQ(network->take(), (Calls{"history of 2 to 1"}));
}

TEST_F(LateReadersTest, AreNotDoneBeforeTheNetworkIs) {
  network->all_left = false;
  EXPECT_FALSE(late.history_sent(1));
  network->all_left = true;
  EXPECT_TRUE(late.history_sent(1));
}

TEST_F(LateReadersTest, AreGivenCopiesInSharedMemoryOfWhatWasPublishedBeforeThereWasAny) {
  late.serve(late_in_memory(2), memory);
  EXPECT_EQ(given(), (Sequences{3, 4}));
  for (const SampleHandle& sample : *memory->given) EXPECT_TRUE(memory->owns(*sample));
  EXPECT_EQ(book->of(1).retained, 2U);
}

TEST_F(LateReadersTest, AreGivenTheSameCopiesAsThoseThatCameBefore) {
  late.serve(late_in_memory(2), memory);
  const std::vector<SampleHandle> first = *memory->given;
  memory->given.reset();
  late.give_history();
  ASSERT_EQ(memory->given->size(), 2U);
  EXPECT_EQ(&*memory->given->front(), &*first.front());
}

TEST_F(LateReadersTest, MissWhatThereIsNoRoomFor) {
  memory->is_full = true;
  late.serve(late_in_memory(2), memory);
  EXPECT_EQ(given(), Sequences{});
  EXPECT_EQ(late.missed(), 2U);
}

TEST_F(LateReadersTest, AreTriedAgainLaterWhileSamplesAreHeldBackFromThemAllTheTime) {
  memory->interruptions = 30;
  late.serve(late_in_memory(1), memory);
  EXPECT_FALSE(memory->given) << "the agent has other things to do";
  late.give_history();
  EXPECT_EQ(given(), (Sequences{4}));
}

TEST_F(LateReadersTest, WaitUntilThereIsSharedMemory) {
  late.serve(late_in_memory(1), nullptr);
  late.give_history();
  EXPECT_FALSE(memory->given);
  late.serve(late_in_memory(1), memory);
  EXPECT_EQ(given(), (Sequences{4}));
}

}  // namespace
}  // namespace sft::core::test
