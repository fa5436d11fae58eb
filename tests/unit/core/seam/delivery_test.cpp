// The counts of readers, while the groups of readers that share a tally change.
#include "core/seam/delivery.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>
#include <vector>

#include "tests/support/test_seed.h"

namespace sft::core {
namespace {

using Origin = DeliveryBook::Origin;
constexpr std::uint64_t first_reader = 7;
constexpr std::uint64_t neighbour = 8;

class DeliveryTest : public ::testing::Test {
 protected:
  using Tally = std::shared_ptr<DeliveryTally>;
  static Tally tally() { return std::make_shared<DeliveryTally>(); }
  void turn_to(const DeliveryBook::Page& page, Origin origin = Origin::network) {
    book.enter(page);
    book.turn_to(origin, page);
  }
  DeliveryBook book;
};

TEST_F(DeliveryTest, AReaderHasWhatWasCountedWhileItWasOnThePage) {
  const Tally group = tally();
  group->sent(10, 100);
  turn_to({{first_reader, {.tally = group}}});
  group->sent(20, 100);
  group->dropped();
  EXPECT_EQ(book.of(first_reader), (Delivered{.sent = 1, .dropped = 1, .bytes = 20, .bytes_saved = 80}));
  turn_to({});
  group->sent(30, 100);
  EXPECT_EQ(book.of(first_reader), (Delivered{.sent = 1, .dropped = 1, .bytes = 20, .bytes_saved = 80}));
  EXPECT_EQ(book.of(neighbour), Delivered{});
}

TEST_F(DeliveryTest, CountsGoOnFromPageToPageAndAddUpOverTellers) {
  const Tally one = tally();
  const Tally other = tally();
  turn_to({{first_reader, {.tally = one}}, {neighbour, {.tally = one}}});
  one->sent(1, 5);
  turn_to({{first_reader, {.tally = other}}, {neighbour, {.tally = one}}});
  one->sent(1, 5);
  other->sent(2, 5);
  const Tally local = tally();
  turn_to({{first_reader, {.tally = local}}}, Origin::publisher);
  local->sent(0, 0);
  EXPECT_EQ(book.of(first_reader), (Delivered{.sent = 3, .bytes = 3, .bytes_saved = 7}));
  EXPECT_EQ(book.of(neighbour), (Delivered{.sent = 2, .bytes = 2, .bytes_saved = 8}));
}

TEST_F(DeliveryTest, WhatIsLeftOfThePageBeforeStillCountsIfItIsExpected) {
  const Tally before = tally(), now = tally();
  const auto count = [](DeliveryTally& tally) {
    tally.sent(1, 5);
    tally.dropped();
  };
  turn_to({{first_reader, {.tally = before}}});
  count(*before);
  book.turn_to(Origin::network, {{first_reader, {.tally = now}}}, DeliveryBook::LateCounts::to_come);
  count(*before);
  count(*now);
  const Delivered all{.sent = 3, .dropped = 3, .bytes = 3, .bytes_saved = 12};
  EXPECT_EQ(book.of(first_reader), all);
  book.turn_to(Origin::network, {});
  EXPECT_EQ(book.of(first_reader), all);
  count(*before);
  EXPECT_EQ(book.of(first_reader), all);
}

TEST_F(DeliveryTest, WhatAGateWithholdsIsItsReadersFromWhenTheyCameToIt) {
  const auto gate = std::make_shared<Gate>(1'000'000);
  const auto withhold = [&gate = *gate] { gate.consider(detail::FieldSource::of_nothing(), 1); };
  withhold();  // the first sample passes
  withhold();
  turn_to({{first_reader, {.gate = gate}}}, Origin::publisher);
  withhold();
  withhold();
  EXPECT_EQ(book.of(first_reader).withheld, 2U);
}

TEST_F(DeliveryTest, WhatAQueueLosesWasNotSent) {
  const Tally group = tally();
  const auto queue = std::make_shared<LossTally>();
  turn_to({{first_reader, {.tally = group, .losses = queue}}, {neighbour, {.tally = group}}});
  for (int i = 0; i < 3; ++i) group->sent(10, 15);
  queue->lost(10, 15);
  EXPECT_EQ(book.of(first_reader), (Delivered{.sent = 2, .dropped = 1, .bytes = 20, .bytes_saved = 10}));
  EXPECT_EQ(book.of(neighbour).sent, 3U);
}

TEST_F(DeliveryTest, WhatWentByASpareRouteIsToldApart) {
  const Tally usual = tally(), fallback = tally();
  book.enter({{first_reader, {}}});
  book.turn_to(DeliveryBook::Origin::publisher, {{first_reader, {.tally = usual}}});
  book.turn_to(DeliveryBook::Origin::network, {{first_reader, {.tally = fallback, .diverted = true}}});
  usual->sent(0, 0);
  fallback->sent(10, 15);
  fallback->sent(10, 15);
  EXPECT_EQ(book.of(first_reader), (Delivered{.sent = 3, .diverted = 2, .bytes = 20, .bytes_saved = 10}));
  book.turn_to(DeliveryBook::Origin::network, {}, DeliveryBook::LateCounts::to_come);
  fallback->sent(10, 15);
  EXPECT_EQ(book.of(first_reader).diverted, 3U);
}

TEST_F(DeliveryTest, WhatWasLostOnASpareRouteWasNotDiverted) {
  const Tally fallback = tally();
  const auto queue = std::make_shared<LossTally>();
  turn_to({{first_reader, {.tally = fallback, .losses = queue, .diverted = true}}});
  for (int i = 0; i < 3; ++i) fallback->sent(10, 15);
  queue->lost(10, 15);
  EXPECT_EQ(book.of(first_reader),
            (Delivered{.sent = 2, .dropped = 1, .diverted = 2, .bytes = 20, .bytes_saved = 10}));
  for (int i = 0; i < 5; ++i) queue->lost(10, 15);
  EXPECT_EQ(book.of(first_reader), (Delivered{.dropped = 3}));
}

TEST_F(DeliveryTest, WhatWasLostOfOthersThatWereThereBeforeIsNotCounted) {
  const Tally group = tally();
  const auto queue = std::make_shared<LossTally>();
  group->sent(10, 15);
  turn_to({{first_reader, {.tally = group, .losses = queue}}});
  queue->lost(10, 15);
  EXPECT_EQ(book.of(first_reader), Delivered{});
}

TEST_F(DeliveryTest, ReadersThatAreGoneStayInTheTotal) {
  const Tally group = tally();
  turn_to({{first_reader, {.tally = group}}, {neighbour, {.tally = group}}});
  group->sent(1, 2);
  book.retained(first_reader, 5);
  book.keep({neighbour});
  group->sent(1, 2);  // counts for both readers, because the page is still in force
  EXPECT_EQ(book.total().sent, 4U);
  turn_to({{neighbour, {.tally = group}}});
  book.keep({neighbour});
  EXPECT_EQ(book.of(first_reader), Delivered{});
  EXPECT_EQ(book.total(), (Delivered{.sent = 4, .retained = 5, .bytes = 4, .bytes_saved = 4}));
}

// The agent enters pages, and the publisher puts only some of them in force. A third thread reads the
// counts.
TEST_F(DeliveryTest, WhileOthersReadAndReadersComeAndGoNoSampleIsMissedOrCountedTwice) {
  test::Random random{test::test_seed()};
  SCOPED_TRACE(test::how_to_repeat());
  std::atomic<bool> stop{false};
  std::thread watcher([&] {
    for (std::uint64_t before = 0; !stop.load();) {
      const std::uint64_t sent = book.of(first_reader).sent;
      EXPECT_GE(sent, before);
      before = sent;
    }
  });
  std::vector<Tally> tallies{tally(), tally(), tally()};
  std::uint64_t published = 0;
  for (int page = 0; page < 1000; ++page) {
    const Tally& mine = tallies[random() % tallies.size()];
    turn_to({{first_reader, {.tally = mine}}, {neighbour, {.tally = tallies[0]}}});
    book.enter({{100 + random() % 5, {}}});
    book.keep({first_reader, random() % 2 == 0 ? neighbour : first_reader});
    for (std::uint64_t i = random() % 10; i > 0; --i, ++published) {
      for (const Tally& t : tallies) t->sent(1, 1);
    }
  }
  stop = true;
  watcher.join();
  EXPECT_EQ(book.of(first_reader).sent, published);
  EXPECT_EQ(book.total().sent, 2 * published);
}

}  // namespace
}  // namespace sft::core
