#include "udp_transport/flow/destination_directory.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "tests/support/heap_bytes.h"
#include "tests/unit/udp/connections.h"

namespace sft::udp {
namespace {

class DestinationDirectoryTest : public testing::Test {
 protected:
  static constexpr std::uint32_t host_ = 0x7F000001;
  const PathMtu::Time now_ = PathMtu::Time{} + std::chrono::hours(1);
  std::vector<core::Network::Remark> remarks_;
  test::Connections connections_;
  DestinationDirectory directory_{{.report_port = 7}, connections_.connect()};
};

TEST_F(DestinationDirectoryTest, GivesEachDestinationANumberThatNobodyGuesses) {
  const auto one = directory_.find({.ip = 1, .port = 1}), two = directory_.find({.ip = 1, .port = 2});
  EXPECT_GT(std::max(one->flow() - two->flow(), two->flow() - one->flow()), 1000U);
}

TEST_F(DestinationDirectoryTest, FindsADestinationByTheNumberThatItsReceiverKnows) {
  const auto one = directory_.find({.ip = 1, .port = 5000});
  const auto other = directory_.find({.ip = 1, .port = 5001});
  EXPECT_EQ(directory_.of_flow(one->flow()), one);
  EXPECT_EQ(directory_.of_flow(other->flow()), other);
  EXPECT_EQ(directory_.of_flow(other->flow() + 1), nullptr);
}

TEST_F(DestinationDirectoryTest, KeepsNothingOfDestinationsThatNobodyUsesAnyMore) {
  std::uint64_t node = 0;
  const auto come_and_go = [&] { directory_.find({.ip = 1, .port = 5000, .node = ++node}); };
  EXPECT_LT(sft::test::bytes_left_by(come_and_go), sft::test::nothing_left);
}

TEST_F(DestinationDirectoryTest, TellsADestinationTheAnnouncedReceiveBuffer) {
  const auto one = directory_.find({.ip = 1, .port = 5000, .receive_buffer_bytes = 1'000'000});
  EXPECT_EQ(one->window().receive_buffer_bytes(), 1'000'000U);
  directory_.find({.ip = 1, .port = 5000});
  EXPECT_EQ(one->window().receive_buffer_bytes(), 1'000'000U) << "nothing else was announced";
}

TEST_F(DestinationDirectoryTest, MovesADestinationToAnotherAddressOfTheSameSocket) {
  const auto at = [&](std::uint32_t ip, std::uint64_t node, std::uint16_t port = 5000) {
    return directory_.find({.ip = ip, .port = port, .node = node});
  };
  const auto there = at(1, 7);
  EXPECT_EQ(at(1, 7), there);
  EXPECT_EQ(there->moves(), 0U);
  EXPECT_EQ(at(2, 7), there);
  EXPECT_EQ(there->moves(), 1U);
  EXPECT_EQ(there->path().address(), (SocketAddress{2, 5000}));
  EXPECT_EQ(connections_.redirected(), (std::vector<SocketAddress>{{2, 5000}}));
  EXPECT_NE(at(2, 7, 5001), there) << "it is another socket of that node";
  EXPECT_NE(at(2, 8), there) << "it is another node, by an address that changed hands";
  EXPECT_EQ(connections_.open(), 1U) << "those two are gone";
}

TEST_F(DestinationDirectoryTest, RemarksOnceForAllProcessesOfAHostThatLongDatagramsDoNotArriveThere) {
  const auto one = directory_.find({.ip = host_, .port = 5000});
  const auto other = directory_.find({.ip = host_, .port = 5001});
  const auto elsewhere = directory_.find({.ip = host_ + 1, .port = 5000});
  for (const auto& to : {one, other}) test::lose_long_ones(*to, connections_, now_);
  directory_.look_after(now_, false, remarks_);
  ASSERT_EQ(remarks_.size(), 1U);
  EXPECT_EQ(remarks_.front().level, LogLevel::warning);
  EXPECT_EQ(remarks_.front().text, one->path().limit_in_words());
  directory_.look_after(now_, false, remarks_);
  EXPECT_EQ(remarks_.size(), 1U) << "it was remarked before";
}

TEST_F(DestinationDirectoryTest, RemarksThatALimitIsOver) {
  const auto there = directory_.find({.ip = host_, .port = 5000, .node = 7});
  test::lose_long_ones(*there, connections_, now_);
  directory_.look_after(now_, false, remarks_);
  remarks_.clear();
  directory_.find({.ip = host_ + 1, .port = 5000, .node = 7});  // a destination on another path
  directory_.look_after(now_, false, remarks_);
  ASSERT_EQ(remarks_.size(), 1U);
  EXPECT_EQ(remarks_.front().level, LogLevel::info);
  EXPECT_EQ(remarks_.front().text, there->path().no_limit_in_words());
}

/// The path is cut in one direction: the process gives heartbeats, so it is still served.
TEST_F(DestinationDirectoryTest, RemarksThatAReceiverDoesNotAnswerForLongAndThatItAnswersAgain) {
  const auto there = directory_.find({.ip = host_, .port = 5000});
  PathMtu::Time now = now_;
  const auto ask_in_vain_for = [&](PathMtu::Time::duration time) {
    for (const auto end = now + time; now < end; now += std::chrono::milliseconds(100)) {
      there->mark(now);
      directory_.look_after(now, false, remarks_);
    }
  };
  ask_in_vain_for(Destination::silence_named_after);
  EXPECT_TRUE(remarks_.empty());
  ask_in_vain_for(std::chrono::seconds(5));
  ASSERT_EQ(remarks_.size(), 1U);
  EXPECT_EQ(remarks_.front().level, LogLevel::warning);
  EXPECT_EQ(remarks_.front().text, there->path().silence_in_words());
  EXPECT_TRUE(there->hear(connections_.answer_to_mark(), core::IpAddress(host_), now).accepted);
  directory_.look_after(now, false, remarks_);
  ASSERT_EQ(remarks_.size(), 2U);
  EXPECT_EQ(remarks_.back().level, LogLevel::info);
  EXPECT_EQ(remarks_.back().text, there->path().no_silence_in_words());
}

TEST_F(DestinationDirectoryTest, FindsADestinationByWhereItIsWhenNobodySaysWhoseItIs) {
  const auto there = directory_.find({.ip = 1, .port = 5000, .node = 7});
  directory_.find({.ip = 2, .port = 5000, .node = 7});
  EXPECT_EQ(directory_.find({.ip = 2, .port = 5000}), there);
  EXPECT_EQ(there->path().address(), (SocketAddress{2, 5000}));
  EXPECT_NE(directory_.find({.ip = 1, .port = 5000}), there);
}

}  // namespace
}  // namespace sft::udp
