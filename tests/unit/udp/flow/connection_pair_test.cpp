#include "udp_transport/flow/connection_pair.h"

#include <gtest/gtest.h>

#include <vector>

#include "tests/unit/udp/connections.h"

namespace sft::udp {
namespace {

class ConnectionPairTest : public testing::Test {
 protected:
  using Addresses = std::vector<SocketAddress>;

  static constexpr std::size_t ethernet = 1472;
  const SocketAddress there_{0x0A000001U, 5000}, elsewhere_{0x0A090003U, 5000};
  RemotePath path_{there_, ethernet};
  test::Connections connections_;
  Addresses connected_to_;
  bool moves_meanwhile_ = false;  ///< true: the remote socket moves while a connection is made
  ConnectionPair pair_{[this](const SocketAddress& to) {
                         connected_to_.push_back(to);
                         if (moves_meanwhile_) path_.move_to(elsewhere_);
                         return connections_.connect()(to);
                       },
                       there_};
};

TEST_F(ConnectionPairTest, MakesAConnectionForLargeSamplesWithTheFirstOfThem) {
  EXPECT_EQ(connections_.open(), 1U);
  EXPECT_EQ(pair_.bulk_in_use(), nullptr);
  Connection& bulk = pair_.bulk(path_);
  EXPECT_NE(&bulk, &pair_.small());
  EXPECT_EQ(pair_.bulk_in_use(), &bulk);
  EXPECT_EQ(&pair_.bulk(path_), &bulk);
  EXPECT_EQ(connections_.open(), 2U);
  EXPECT_EQ(connected_to_, (Addresses{there_, there_}));
}

TEST_F(ConnectionPairTest, PutsLargeSamplesLastInLine) {
  EXPECT_EQ(&pair_.last_in_line(), &pair_.small());
  Connection& bulk = pair_.bulk(path_);
  EXPECT_EQ(&pair_.last_in_line(), &bulk);
}

TEST_F(ConnectionPairTest, ConnectsForLargeSamplesToWhereTheSocketIsByThen) {
  EXPECT_TRUE(path_.move_to(elsewhere_));
  pair_.bulk(path_);
  EXPECT_EQ(connected_to_, (Addresses{there_, elsewhere_}));
  EXPECT_EQ(connections_.redirected(), Addresses{});
}

TEST_F(ConnectionPairTest, RedirectsTheConnectionIfTheSocketMovesWhileItIsMade) {
  moves_meanwhile_ = true;
  pair_.bulk(path_);
  EXPECT_EQ(connections_.redirected(), Addresses{elsewhere_});
}

TEST_F(ConnectionPairTest, RedirectsAndReconnectsBoth) {
  pair_.redirect(elsewhere_);
  pair_.reconnect();
  EXPECT_EQ(connections_.redirected(), Addresses{elsewhere_});
  EXPECT_EQ(connections_.reconnected(), 1U);
  pair_.bulk(path_);
  pair_.redirect(there_);
  pair_.reconnect();
  EXPECT_EQ(connections_.redirected(), (Addresses{elsewhere_, there_, there_}));
  EXPECT_EQ(connections_.reconnected(), 3U);
}

TEST_F(ConnectionPairTest, SendsOneDatagramAtATimeUntilTheWayIsAnotherOne) {
  EXPECT_EQ(pair_.datagrams_per_call(), batch_datagrams_max);
  pair_.take_one_at_a_time();
  EXPECT_EQ(pair_.datagrams_per_call(), 1U);
  pair_.reconnect();
  EXPECT_EQ(pair_.datagrams_per_call(), 1U);
  pair_.redirect(elsewhere_);
  EXPECT_EQ(pair_.datagrams_per_call(), batch_datagrams_max);
}

}  // namespace
}  // namespace sft::udp
