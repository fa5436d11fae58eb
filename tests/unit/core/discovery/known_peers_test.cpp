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
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using namespace std::chrono_literals;

class Listener final : public DiscoveryListener {
 public:
  void endpoint_seen(Endpoint) override {}
  void endpoint_departed(EndpointId) override {}
  void endpoint_lost(EndpointId) override {}
  void request_received(Request) override {}
  void report_received(NodeReport) override {}
  void log_news(News news, std::string text) override {
    if (news == News::malformed) on_refusal(text);
    if (news == News::warning) warnings.push_back(text);
  }

  std::function<void(const std::string&)> on_refusal;
  std::vector<std::string> warnings;
};

class KnownPeersTest : public ::testing::Test {
 protected:
  KnownPeersTest() {
    known.with([&](Peers&, Directory& directory) { node = directory.join(listener); });
  }
  std::vector<std::string> warnings() {
    known.look(now);
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
      known.with([&](Peers&, Directory& directory) {
        directory.log_news(Directory::News::malformed, std::to_string(next++));
      });
    }
  };
  std::vector<std::thread> workers;
  for (int i = 0; i < threads; ++i) workers.emplace_back(work);
  for (std::thread& worker : workers) worker.join();
  EXPECT_FALSE(overlapped);
  ASSERT_EQ(delivered.size(), static_cast<std::size_t>(threads * events_each));
  for (int i = 0; i < threads * events_each; ++i) ASSERT_EQ(delivered[static_cast<std::size_t>(i)], i);
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
