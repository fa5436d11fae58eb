// The ear compares what others say of themselves with what it knows, as far as it listens to them.
#include "core/discovery/discovery_ear.h"

#include <gtest/gtest.h>

#include <utility>

#include "core/discovery/own_announcements.h"

namespace sft::core {
namespace {

constexpr Speaker peer{1, 11};
constexpr NodeId its_node = 77;

class DiscoveryEarTest : public ::testing::Test {
 protected:
  DiscoveryEarTest() {
    ear.link_expected(peer.link);
    ear.participant_speaks(peer);
    for (const auto& [role, id] : {std::pair(Role::writer, 5), std::pair(Role::reader, 6)}) {
      Endpoint endpoint;
      endpoint.id = static_cast<EndpointId>(id);
      endpoint.role = role;
      endpoint.node_id = its_node;
      (void)own.announce(endpoint);
    }
  }

  void hears(Role role) { ear.hears(role, now()); }
  void announcement_comes(Role role) {
    Endpoint endpoint;
    endpoint.id = role == Role::writer ? 5 : 6;
    endpoint.role = role;
    endpoint.node_id = its_node;
    endpoint.revision = 1;
    ear.endpoint_came(peer, endpoint);
  }
  /// True if something that the peer has announced seems to be missing.
  bool doubts() {
    Assertion sign{.node = its_node, .writers = {}};
    sign.digest_of_writers = own.digest(Role::writer);
    sign.digest_of_readers = own.digest(Role::reader);
    ear.assertion_came(peer, sign, std::chrono::seconds(60));  // no sign comes too late
    at += std::chrono::milliseconds(500);                      // it does not look more often
    (void)ear.look_for_deafness(std::chrono::seconds(20), now());
    return ear.tick(now()).signs.wants();
  }

  DiscoveryEar ear{lease_default};

 private:
  Time now() const { return at; }

  OwnAnnouncements own;  ///< of the peer
  Time at = std::chrono::steady_clock::now();
};

TEST_F(DiscoveryEarTest, MissesNothingOfARoleThatItDoesNotListenTo) {
  EXPECT_FALSE(doubts()) << "it listens to nobody";
  hears(Role::writer);
  EXPECT_TRUE(doubts());
  announcement_comes(Role::writer);
  EXPECT_FALSE(doubts());
  hears(Role::reader);
  EXPECT_TRUE(doubts());
  announcement_comes(Role::reader);
  EXPECT_FALSE(doubts());
}

}  // namespace
}  // namespace sft::core
