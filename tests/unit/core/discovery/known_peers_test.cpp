// The nodes of a process are notified in order of the events that Cyclone's threads report.
#include "core/discovery/known_peers.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <thread>
#include <variant>
#include <vector>

namespace sft::core {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using namespace std::chrono_literals;

class KnownPeersTest : public ::testing::Test {
 protected:
  KnownPeersTest() {
    known.with([&](Peers&, Directory& directory) { node = directory.join([this] { on_wake(); }); });
  }
  /// Returns what the node has been notified of since the last call.
  std::vector<std::string> taken() {
    std::vector<std::string> texts;
    for (const DiscoveryEvent& event :
         known.with([&](Peers&, Directory& directory) { return directory.take_events(*node); }))
      texts.push_back(std::get<DiscoveryNews>(event).text);
    return texts;
  }
  std::vector<std::string> warnings() {
    known.look(now);
    return taken();
  }

  const Timing timing;
  const Time now = Time(100s);
  std::function<void()> on_wake = [] {};
  KnownPeers known{64, timing};
  std::shared_ptr<ListeningNode> node;
};

TEST_F(KnownPeersTest, NotifiesInTheOrderOfEventsOfAllThreads) {
  constexpr int threads = 4, events_each = 2000;
  int next = 0;  // guarded by the mutex of KnownPeers
  const auto work = [&] {
    for (int i = 0; i < events_each; ++i) {
      known.with([&](Peers&, Directory& directory) {
        directory.log_news(Directory::News::warning, std::to_string(next++));
      });
    }
  };
  std::vector<std::thread> workers;
  for (int i = 0; i < threads; ++i) workers.emplace_back(work);
  for (std::thread& worker : workers) worker.join();
  const std::vector<std::string> delivered = taken();
  ASSERT_EQ(delivered.size(), static_cast<std::size_t>(threads * events_each));
  for (int i = 0; i < threads * events_each; ++i)
    ASSERT_EQ(delivered[static_cast<std::size_t>(i)], std::to_string(i));
}

TEST_F(KnownPeersTest, WakesNodesWithoutItsLock) {
  std::vector<std::string> texts;
  on_wake = [&] { texts = taken(); };
  known.sample_refused("malformed");
  EXPECT_THAT(texts, IsEmpty()) << "there may be a flood of these";
  known.with(
      [](Peers&, Directory& directory) { directory.log_news(Directory::News::warning, "another release"); });
  EXPECT_THAT(texts, ElementsAre("malformed", "another release"));
}

TEST_F(KnownPeersTest, NamesEachOtherReleaseOnce) {
  known.other_release_seen(1, 3);
  known.other_release_seen(1, 4);
  known.other_release_seen(2, 3);
  EXPECT_THAT(warnings(), ElementsAre(HasSubstr("a participant with control protocol 3 is on"),
                                      HasSubstr("a participant with control protocol 4 is on")));
  known.other_release_seen(1, 3);
  EXPECT_THAT(warnings(), IsEmpty());
}

TEST_F(KnownPeersTest, NamesAFewReleasesHoweverManyAreMadeUp) {
  for (std::uint32_t version = 100; version < 1000; ++version) known.other_release_seen(1, version);
  EXPECT_THAT(warnings(), SizeIs(16));
}

}  // namespace
}  // namespace sft::core
