// The nodes of a process are notified in order of the events that Cyclone's threads report.
#include "core/discovery/known_peers.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <functional>
#include <string>
#include <thread>
#include <vector>

namespace sft::core {
namespace {

using ::testing::ElementsAre;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using namespace std::chrono_literals;

class Listener final : public DiscoveryListener {
 public:
  void endpoint_seen(Endpoint) override {}
  void endpoint_departed(EndpointId) override {}
  void endpoint_lost(EndpointId) override {}
  void request_received(Request) override {}
  void report_received(NodeReport) override {}
  void control_malformed(std::string why) override { on_refusal(why); }
  void warned(std::string what) override { warnings.push_back(std::move(what)); }

  std::function<void(const std::string&)> on_refusal;
  std::vector<std::string> warnings;
};

class KnownPeersTest : public ::testing::Test {
 protected:
  KnownPeersTest() {
    known.with([&](Peers&, Directory& directory) { node = directory.join(listener); });
  }
  void refuse(const std::vector<std::string>& texts) {
    known.with([&](Peers&, Directory& directory) {
      for (const std::string& text : texts) directory.refuse(text);
    });
    known.pass_on();
  }
  void other_release(std::uint8_t participant, LinkId link = 1) {
    known.other_release_seen({link, {participant}}, 3);
  }
  std::vector<std::string> warnings_at(Time time) {
    known.tell_of_other_releases(time);
    known.pass_on();
    return std::exchange(listener.warnings, {});
  }

  const Timing timing;
  const Time now = Time(100s);
  Listener listener;
  KnownPeers known{64, timing};
  std::shared_ptr<ListeningNode> node;
};

TEST_F(KnownPeersTest, NotifiesOneAtATimeInTheOrderOfEventsOfAllThreads) {
  constexpr int threads = 4, events_each = 2000;
  int next = 0;                // guarded by the mutex of KnownPeers
  std::vector<int> delivered;  // written by one thread at a time
  std::atomic<int> inside{0};
  std::atomic<bool> overlapped{false};
  listener.on_refusal = [&](const std::string& text) {
    if (inside.fetch_add(1) != 0) overlapped = true;
    delivered.push_back(std::stoi(text));
    inside.fetch_sub(1);
  };
  const auto work = [&] {
    for (int i = 0; i < events_each; ++i) {
      known.with([&](Peers&, Directory& directory) { directory.refuse(std::to_string(next++)); });
      known.pass_on();
    }
  };
  std::vector<std::thread> workers;
  for (int i = 0; i < threads; ++i) workers.emplace_back(work);
  for (std::thread& worker : workers) worker.join();
  EXPECT_FALSE(overlapped);
  ASSERT_EQ(delivered.size(), static_cast<std::size_t>(threads * events_each));
  for (int i = 0; i < threads * events_each; ++i) ASSERT_EQ(delivered[static_cast<std::size_t>(i)], i);
}

TEST_F(KnownPeersTest, HoldsNoLockWhileItNotifies) {
  std::vector<std::string> delivered;
  listener.on_refusal = [&](const std::string& text) {
    delivered.push_back(text);
    if (text == "1") known.sample_refused("3");  // would wait for ever if this thread held the lock
  };
  refuse({"1", "2"});
  EXPECT_THAT(delivered, ElementsAre("1", "2", "3"));
}

TEST_F(KnownPeersTest, NamesAParticipantOfAnotherReleaseOnce) {
  other_release(1);
  other_release(1);
  EXPECT_THAT(warnings_at(now), ElementsAre(HasSubstr("a participant with control protocol 3 is on")));
  other_release(1);
  EXPECT_THAT(warnings_at(now + timing.name_releases_every), IsEmpty());
}

TEST_F(KnownPeersTest, NamesManyOfOtherReleasesInOneLineInAWhile) {
  other_release(1);
  EXPECT_THAT(warnings_at(now), ElementsAre(Not(HasSubstr("more"))));
  for (std::uint8_t participant = 2; participant < 100; ++participant) other_release(participant);
  EXPECT_THAT(warnings_at(now + timing.name_releases_every - 1ms), IsEmpty());
  EXPECT_THAT(warnings_at(now + timing.name_releases_every),
              ElementsAre(EndsWith("(97 more with another protocol have come)")));
}

TEST_F(KnownPeersTest, NamesAParticipantOfAnotherReleaseAgainThatWasGone) {
  other_release(1);
  EXPECT_THAT(warnings_at(now), Not(IsEmpty()));
  known.participant_gone({1, {1}});
  other_release(1);
  EXPECT_THAT(warnings_at(now + timing.name_releases_every), Not(IsEmpty()));
}

TEST_F(KnownPeersTest, HasRoomForOtherReleasesOnceALinkIsGone) {
  for (int participant = 0; participant < 256; ++participant)
    other_release(static_cast<std::uint8_t>(participant));
  EXPECT_THAT(warnings_at(now), Not(IsEmpty()));
  known.link_closed(1);
  other_release(1, 2);
  EXPECT_THAT(warnings_at(now + timing.name_releases_every), Not(IsEmpty()));
}

}  // namespace
}  // namespace sft::core
