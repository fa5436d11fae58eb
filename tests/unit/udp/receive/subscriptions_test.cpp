// These tests check from which writers the readers of a transport may receive at the same time.
#include "udp_transport/receive/subscriptions.h"

#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <set>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "tests/unit/udp/datagrams.h"

namespace sft::udp {
namespace {

class SubscriptionsTest : public testing::Test {
 protected:
  SubscriptionsTest() { directory_.add(1, inbox_, test::type_support<test::Image>()); }

  bool connects(core::EndpointId writer) {
    return directory_.connect(*inbox_, {.writer = writer}).has_value();
  }
  void dies(core::EndpointId writer) { directory_.announced(*inbox_, {.writer = writer, .alive = false}); }
  static core::EndpointId twin(std::uint64_t number) { return (number << 32) + 5; }

  std::shared_ptr<Inbox> inbox_ = std::make_shared<Inbox>(1, nullptr);
  SubscriptionDirectory directory_;
};

TEST_F(SubscriptionsTest, WritersWithOneShortIdAreHeardBesideEachOther) {
  EXPECT_TRUE(connects(twin(0)));
  EXPECT_TRUE(connects(twin(1)));
  EXPECT_EQ(directory_.enter()->streams.size(), 2U);
  directory_.leave();
}

TEST_F(SubscriptionsTest, AtMost64LivingWritersWithOneShortIdAreHeard) {
  for (std::uint64_t number = 0; number < 64; ++number) EXPECT_TRUE(connects(twin(number))) << number;
  EXPECT_FALSE(connects(twin(64)));
  EXPECT_TRUE(connects(twin(3))) << "it is one of them";
  EXPECT_TRUE(connects(6)) << "another short id";
  dies(twin(7));
  EXPECT_TRUE(connects(twin(64)));
}

TEST_F(SubscriptionsTest, WhatAWriterAnnouncesAnewIsTakenOver) {
  ASSERT_TRUE(directory_.connect(*inbox_, {.writer = 6, .max_sample_bytes = 1}));
  directory_.announced(*inbox_, {.writer = 6, .max_sample_bytes = 1000, .reliable = true, .waits = true});
  const auto subscriptions = directory_.enter();
  ASSERT_EQ(subscriptions->streams.size(), 1U);
  EXPECT_EQ(subscriptions->streams[0].max_sample_bytes, 1000U);
  EXPECT_TRUE(subscriptions->streams[0].reliable);
  EXPECT_TRUE(subscriptions->streams[0].waits);
  directory_.leave();
}

TEST_F(SubscriptionsTest, AReaderIsRemovedOnceTheReceivingThreadDoesNotUseItsTypeAnyMore) {
  ASSERT_TRUE(connects(6));
  std::atomic<bool> entered{false};
  bool has_left = false;  // Not atomic: remove() has to order the two threads' accesses.
  std::thread receiving([&] {
    const auto subscriptions = directory_.enter();
    entered = true;
    entered.notify_all();
    // Gives remove() enough time to return too early, in case it has this error.
    for (int i = 0; i < 1000; ++i) std::this_thread::yield();
    EXPECT_FALSE(subscriptions->streams[0].type->name().empty());
    has_left = true;
    directory_.leave();
  });
  entered.wait(false);
  directory_.remove(*inbox_);
  EXPECT_TRUE(has_left);
  EXPECT_TRUE(directory_.enter()->streams.empty());
  directory_.leave();
  receiving.join();
}

TEST_F(SubscriptionsTest, WhatManyReadersAskedForInTurnIsWantedOfTheirWriterOnce) {
  constexpr std::uint64_t readers = 64, requests = 16;
  std::vector<std::shared_ptr<Inbox>> inboxes;
  for (std::uint64_t reader = 0; reader < readers; ++reader) {
    inboxes.push_back(std::make_shared<Inbox>(1, nullptr));
    directory_.add(100 + reader, inboxes.back(), test::type_support<test::Image>());
    ASSERT_TRUE(directory_.connect(*inboxes.back(), {.writer = 5}));
    std::vector<core::Accepted> accepted;
    for (std::uint64_t i = 0; i < requests; ++i) {
      const std::string window = "data[" + std::to_string(8 * reader + i) + ":10000]";
      accepted.push_back({.wanted = {test::selection_of<test::Image>(window)}});
    }
    directory_.accept(*inboxes.back(), std::move(accepted));
  }
  const std::shared_ptr<const Subscriptions> wanted = directory_.enter();
  directory_.leave();
  ASSERT_EQ(wanted->streams.size(), 1U);
  EXPECT_EQ(wanted->streams[0].selections.size(), 8 * (readers - 1) + requests) << "neighbours share half";
  std::set<std::uint64_t> hashes;
  for (const Selection& selection : wanted->streams[0].selections) hashes.insert(selection.hash());
  EXPECT_EQ(hashes.size(), wanted->streams[0].selections.size());
  ASSERT_EQ(wanted->subscribers[0].size(), readers);
  EXPECT_EQ(wanted->subscribers[0].back().accepted->size(), requests);
}

/// Returns a subscriber that has requested these selections one after the other.
Subscriber subscriber_of(const std::vector<const char*>& asked) {
  std::vector<core::Accepted> accepted;
  for (const char* text : asked) accepted.push_back({.wanted = {test::selection_of<test::Image>(text)}});
  return {.inbox = {}, .accepted = std::make_shared<const std::vector<core::Accepted>>(std::move(accepted))};
}

TEST(SubscriberOfParts, TakesItsPartAndMergedSamplesThatHaveTheWholeField) {
  const Subscriber subscriber = subscriber_of({"data[::3]"});
  core::SampleBuffer sample;
  sample.mask = test::fields<test::Image>("data");
  sample.parts = test::selection_of<test::Image>("data[::3]").parts_hash();
  EXPECT_TRUE(subscriber.accepts(sample));
  sample.parts = test::selection_of<test::Image>("data[::4]").parts_hash();
  EXPECT_FALSE(subscriber.accepts(sample)) << "another part";
  sample.parts = 0;
  EXPECT_FALSE(subscriber.accepts(sample)) << "the whole field was sent to another reader";
  sample.merged = true;
  EXPECT_TRUE(subscriber.accepts(sample));
  sample.mask = test::fields<test::Image>("data, height");
  EXPECT_TRUE(subscriber.accepts(sample));
  sample.mask = test::fields<test::Image>("height");
  EXPECT_FALSE(subscriber.accepts(sample));
}

TEST(SubscriberOfParts, TakesNoMergedSampleIfItHasConditions) {
  core::SampleBuffer sample;
  sample.mask = test::fields<test::Image>("*");
  sample.merged = true;
  EXPECT_FALSE(subscriber_of({"data[::3] @ height > 4"}).accepts(sample));
  EXPECT_TRUE(subscriber_of({"data[::3] @ height > 4", "data[::3]"}).accepts(sample));
}

}  // namespace
}  // namespace sft::udp
