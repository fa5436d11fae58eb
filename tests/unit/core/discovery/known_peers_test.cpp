// What the agents of a process are told of the participants that its links have found.
#include "core/discovery/known_peers.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sft::core {
namespace {

using ::testing::HasSubstr;
using ::testing::Optional;

class KnownPeersTest : public ::testing::Test {
 protected:
  void other_release_seen(LinkId link) { peers.other_release_seen(participant_on(link), version); }
  static RemoteParticipant participant_on(LinkId link) { return {link, {1}}; }
  /// Returns what the log says of participants of other releases, at the next time at which it may say so.
  std::optional<std::string> other_releases() {
    now += timing.name_releases_every;
    return peers.take_other_releases(now);
  }

  static constexpr std::uint32_t version = 9999;
  const Timing timing;
  Time now = std::chrono::steady_clock::now();
  KnownPeers peers{64, timing};
};

TEST_F(KnownPeersTest, NameAParticipantOfAnotherReleaseOnceUntilItReturns) {
  other_release_seen(1);
  EXPECT_THAT(other_releases(), Optional(HasSubstr("control protocol 9999")));
  other_release_seen(1);
  EXPECT_FALSE(other_releases()) << "Cyclone tells of a participant more than once";
  peers.participant_gone(participant_on(1));
  other_release_seen(1);
  EXPECT_TRUE(other_releases());
}

TEST_F(KnownPeersTest, NameAParticipantOfAnotherReleaseAgainOnALinkThatWasMadeAnew) {
  peers.link_made(1, {.interface = "eth0"});
  other_release_seen(1);
  EXPECT_THAT(other_releases(), Optional(HasSubstr("is on eth0")));
  peers.link_closed(1);
  peers.link_made(1, {.interface = "eth0"});
  other_release_seen(1);
  EXPECT_TRUE(other_releases());
}

}  // namespace
}  // namespace sft::core
