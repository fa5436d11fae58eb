// Tests of publishing and subscribing that every transport must pass in the same way.
#include <algorithm>
#include <array>
#include <atomic>
#include <optional>
#include <thread>

#include "tests/system/fixture.h"

namespace sft::test {
namespace {

using namespace detail;

TEST_P(PubSubTest, ASampleArrivesWhole) {
  Node a = open("a");
  Node b = open("b");
  auto pub = a.publisher<PointCloud2>("points").value();
  auto sub = b.subscriber<PointCloud2>("points").value();
  expect_served(pub, 1);
  const PointCloud2 sent = cloud(7, 300'000);
  EXPECT_EQ(pub.publish(sent), PublishStatus::ok);
  ASSERT_TRUE(sub.wait(hang_timeout));
  const auto sample = sub.take();
  EXPECT_EQ(sample.to_owned(), sent);
  EXPECT_EQ(sample.info().transport, in_shared_memory() ? TransportKind::shm : TransportKind::udp);
}

TEST_P(PubSubTest, SamplesArriveThatAreAsLargeAsTheirPublisherAnnouncesAndLargerOnesAreRefused) {
  constexpr std::size_t most = 16 * 1024 * 1024;
  expected_warning = "a message is not sent: topic 'points': ";
  Node a = open("a");
  Node b = open("b");
  auto pub = a.publisher<PointCloud2>("points", {.max_sample_bytes = most}).value();
  auto sub = b.subscriber<PointCloud2>("points").value();
  expect_served(pub, 1);
  const PointCloud2 sent = cloud(7, most - 400);
  EXPECT_EQ(pub.publish(sent), PublishStatus::ok);
  ASSERT_TRUE(sub.wait(10s));
  EXPECT_EQ(sub.take().to_owned(), sent);
  EXPECT_EQ(pub.publish(cloud(8, most)), PublishStatus::invalid);
  EXPECT_NE(pub.why_invalid().find("16777220 of them in 'data'"), std::string::npos) << pub.why_invalid();
}

TEST_P(PubSubTest, APublisherOfSamplesThatNothingCarriesIsRefused) {
  Node a = open("a");
  const auto pub = a.publisher<PointCloud2>("points", {.max_sample_bytes = 1 << 30});
  ASSERT_FALSE(pub);
  EXPECT_EQ(pub.error().code, Errc::limit_exceeded);
}

TEST_P(PubSubTest, EachSubscriberGetsTheFieldsItDeclared) {
  Node a = open("a");
  Node b = open("b");
  auto pub = a.publisher<PointCloud2>("points").value();
  auto scalars = b.subscriber<PointCloud2, F::height | F::width>("points").value();
  auto names = b.subscriber<PointCloud2, F::fields.each.name>("points").value();
  expect_served(pub, 2);
  pub.publish(cloud(7));
  ASSERT_TRUE(scalars.wait(hang_timeout) && names.wait(hang_timeout));
  const auto scalar = scalars.take();
  EXPECT_EQ(scalar->height(), 7U);
  EXPECT_EQ(scalar->width(), 8U);
  const auto name = names.take();
  ASSERT_EQ(name->fields().size(), 2U);
  EXPECT_EQ((*std::next(name->fields().begin())).name(), "y");
  EXPECT_EQ(scalar.mask().is_full(), in_shared_memory());
  if (!in_shared_memory()) {
    EXPECT_EQ(scalar.mask(), FieldMask(F::height | F::width));
  }
}

TEST_P(PubSubTest, MessagesThatArePublishedTogetherAreSamplesLikeOthers) {
  expected_warning = "a message is not sent: topic 'points': ";
  Node a = open("a");
  Node b = open("b");
  auto pub = a.publisher<PointCloud2>("points", {.reliability = reliable, .max_blocking = 100ms}).value();
  auto sub = b.subscriber<PointCloud2>("points", {.reliability = reliable, .depth = 30}).value();
  expect_served(pub, 1);
  std::vector<PointCloud2> clouds;
  for (std::uint32_t i = 0; i < 20; ++i) clouds.push_back(cloud(i, i == 10 ? 5000 : 20));
  clouds[5].header.frame_id = std::string("\0", 1);
  const PublishedSpan done = pub.publish(clouds);
  EXPECT_EQ(done.published, 19U);
  EXPECT_EQ(done.status, PublishStatus::invalid);
  clouds.erase(clouds.begin() + 5);
  for (std::uint64_t sequence = 1; const PointCloud2& sent : clouds) {
    ASSERT_TRUE(sub.wait(hang_timeout));
    const auto sample = sub.take();
    EXPECT_EQ(sample.to_owned(), sent);
    EXPECT_EQ(sample.info().sequence, sequence++);
    EXPECT_EQ(sample.info().lost_before, 0U);
  }
  EXPECT_EQ(pub.status().readers.at(0).sent, 19U);
}

TEST_P(PubSubTest, WithoutReadersNothingIsSent) {
  Node a = open("a");
  auto pub = a.publisher<PointCloud2>("points").value();
  for (std::uint32_t i = 0; i < 10; ++i) EXPECT_EQ(pub.publish(cloud(i)), PublishStatus::ok);
  EXPECT_EQ(pub.status().bytes_sent, 0U);
  EXPECT_EQ(pub.status().published, 10U);
}

TEST_P(PubSubTest, ALoanIsFilledInPlace) {
  Node a = open("a");
  Node b = open("b");
  auto pub = a.publisher<PointCloud2>("points").value();
  auto sub = b.subscriber<PointCloud2>("points").value();
  expect_served(pub, 1);
  PointCloud2 expected = cloud(3);
  expected.data.assign(100'000, 9);
  auto loan = pub.loan(cloud(3), {.data = 100'000}).value();
  std::fill(loan->data().begin(), loan->data().end(), std::uint8_t{9});
  loan.set(F::width, 44);
  loan.set(F::header.stamp.nanosec, 55);
  EXPECT_EQ(std::move(loan).publish(), PublishStatus::ok);
  expected.width = 44;
  expected.header.stamp.nanosec = 55;
  ASSERT_TRUE(sub.wait(hang_timeout));
  EXPECT_EQ(sub.take().to_owned(), expected);
}

TEST_P(PubSubTest, LoansThatAreNotPublishedGiveTheirMemoryBack) {
  Node a = open("a");
  Node b = open("b");
  auto pub = a.publisher<PointCloud2>("points").value();
  auto sub = b.subscriber<PointCloud2>("points").value();
  expect_served(pub, 1);
  for (int i = 0; i < 500; ++i) ASSERT_TRUE(pub.loan(cloud(3), {.data = 1'000'000}));
}

TEST_P(PubSubTest, OtherThreadsMayFillAndDropLoansWhileTheirPublisherPublishes) {
  Node a = open("a");
  Node b = open("b");
  auto pub = a.publisher<PointCloud2>("points", {.reliability = reliable}).value();
  auto sub = b.subscriber<PointCloud2>("points", {.reliability = reliable, .depth = 10}).value();
  expect_served(pub, 1);
  const auto next = [&] { return sub.wait(hang_timeout) ? sub.take().to_owned() : PointCloud2{}; };
  for (std::uint32_t i = 1; i <= 100; ++i) {
    auto loan = pub.loan(cloud(i), {.data = 50'000}).value();
    std::optional dropped(pub.loan(cloud(0), {.data = 50'000}).value());
    std::thread filling([&] { std::ranges::fill(loan->data(), static_cast<std::uint8_t>(i)); });
    std::thread dropping([&] { dropped.reset(); });
    EXPECT_EQ(pub.publish(cloud(i, 20'000)), PublishStatus::ok);
    filling.join();
    EXPECT_EQ(std::move(loan).publish(), PublishStatus::ok);
    dropping.join();
    PointCloud2 filled = cloud(i);
    filled.data.assign(50'000, static_cast<std::uint8_t>(i));
    ASSERT_EQ(next(), cloud(i, 20'000));
    ASSERT_EQ(next(), filled);
  }
}

TEST_P(PubSubTest, ALoanThatShrankArrivesAsIfItHadBeenMadeSo) {
  Node a = open("a");
  Node b = open("b");
  auto pub = a.publisher<PointCloud2>("points").value();
  auto sub = b.subscriber<PointCloud2>("points").value();
  auto scalars = b.subscriber<PointCloud2, F::is_dense>("points").value();
  expect_served(pub, 2);
  auto loan = pub.loan(cloud(3), {.data = 100'000}).value();
  std::fill(loan->data().begin(), loan->data().end(), std::uint8_t{9});
  loan.set(F::is_dense, true);
  EXPECT_EQ(loan.shrink(F::data, 33'333), ShrinkStatus::ok);
  EXPECT_EQ(std::move(loan).publish(), PublishStatus::ok);
  PointCloud2 expected = cloud(3);
  expected.data.assign(33'333, 9);
  expected.is_dense = true;
  ASSERT_TRUE(sub.wait(hang_timeout) && scalars.wait(hang_timeout));
  EXPECT_EQ(sub.take().to_owned(), expected);
  const auto scalar = scalars.take();
  EXPECT_TRUE(scalar->is_dense());
}

TEST_P(PubSubTest, NothingOfEarlierSamplesIsInALoan) {
  Node a = open("a");
  Node b = open("b");
  auto pub = a.publisher<PointCloud2>("points").value();
  auto sub = b.subscriber<PointCloud2>("points").value();
  expect_served(pub, 1);
  PointCloud2 canaries = cloud(3);
  canaries.header.frame_id.assign(40, '\xA5');
  canaries.data.assign(50'000, 0xA5);
  const PointCloud2 prototype = cloud(4);
  PointCloud2 expected = prototype;
  expected.data.assign(41'111, 0);
  expected.data[7] = 1;
  for (int round = 0; round < 20; ++round) {
    pub.publish(canaries);
    ASSERT_TRUE(sub.wait(hang_timeout));
    EXPECT_EQ(sub.take().to_owned(), canaries);
    auto loan = pub.loan(prototype, {.data = 50'011}).value();
    loan->data()[7] = 1;
    loan.shrink(F::data, 41'111);
    EXPECT_EQ(std::move(loan).publish(), PublishStatus::ok);
    ASSERT_TRUE(sub.wait(hang_timeout));
    const auto sample = sub.take();
    EXPECT_EQ(sample.to_owned(), expected);
    EXPECT_EQ(std::ranges::count(sample.cdr(), std::byte{0xA5}), 0);
    if (!in_shared_memory()) continue;
    // The header, the index and padding precede the body.
    const std::size_t body_offset = SampleLayout(pub.type().index_slots()).body_offset;
    const std::span chunk(sample.cdr().data() + encapsulation_bytes - body_offset, body_offset);
    EXPECT_TRUE(std::ranges::search_n(chunk, 3, std::byte{0xA5}).empty());
  }
}

TEST_P(PubSubTest, ElementsAreReachedByTheirPosition) {
  Node a = open("a");
  Node b = open("b");
  auto pub = a.publisher<PointCloud2>("points").value();
  auto sub = b.subscriber<PointCloud2, F::fields>("points").value();
  auto rec = b.subscriber<PointCloud2, recorded>("points").value();
  expect_served(pub, 2);
  PointCloud2 message = cloud(1);
  message.fields.resize(100);
  for (std::size_t i = 0; i < 100; ++i) message.fields[i].name = std::to_string(1000 + i);
  pub.publish(message);
  ASSERT_TRUE(sub.wait(hang_timeout) && rec.wait(hang_timeout));
  const auto sample = sub.take();
  const auto fields = sample->fields();
  EXPECT_EQ(fields[70].name(), "1070");
  EXPECT_EQ(std::ranges::lower_bound(fields, "1033", {}, [](const auto& f) { return f.name(); })->name(),
            "1033");
  const auto recorded_sample = rec.take();
  EXPECT_EQ((*recorded_sample->fields()).back().name(), "1099");
}

TEST_P(PubSubTest, ASlashInFrontOfATopicCountsForNothingAndIsNotShown) {
  Node a = open("a");
  Node b = open("b");
  auto pub = a.publisher<PointCloud2>("/left/points").value();
  auto sub = b.subscriber<PointCloud2, F::height>("left/points").value();
  expect_served(pub, 1);
  pub.publish(cloud(7));
  ASSERT_TRUE(sub.wait(hang_timeout));
  EXPECT_EQ(a.snapshot().publishers.at(0).topic, "left/points");
  EXPECT_TRUE(b.find_type("/left/points", hang_timeout));
  ASSERT_EQ(b.topics().size(), 1U);
  EXPECT_EQ(b.topics()[0].name, "left/points");
}

TEST_P(PubSubTest, APublisherWaitsForAsManySubscribersAsItIsTold) {
  Node a = open("a");
  Node b = open("b");
  auto pub = a.publisher<PointCloud2>("points").value();
  EXPECT_TRUE(pub.wait_for_subscribers(0, 0s));
  EXPECT_FALSE(pub.wait_for_subscribers(1, 20ms));
  std::optional<Subscriber<PointCloud2, F::height>> first;
  std::thread opener([&] { first.emplace(b.subscriber<PointCloud2, F::height>("points").value()); });
  EXPECT_TRUE(pub.wait_for_subscribers(1, 20s));
  opener.join();
  pub.publish(cloud(7));
  EXPECT_TRUE(first->wait(hang_timeout)) << "what is published then is sent to it";
  EXPECT_FALSE(pub.wait_for_subscribers(2, 20ms));
  auto second = b.subscriber<PointCloud2, F::width>("points").value();
  EXPECT_TRUE(pub.wait_for_subscribers(2, std::chrono::nanoseconds::max()));
  first.reset();
  expect_served(pub, 1);
  EXPECT_FALSE(pub.wait_for_subscribers(2, 0s));
}

TEST_P(PubSubTest, SamplesCarryTheirMetadata) {
  Node a = open("a");
  Node b = open("b");
  auto pub = a.publisher<PointCloud2>("points").value();
  auto sub = b.subscriber<PointCloud2, F::height>("points").value();
  expect_served(pub, 1);
  const auto before = std::chrono::system_clock::now();
  for (std::uint32_t i = 0; i < 3; ++i) pub.publish(cloud(i));
  std::uint64_t last = 0;
  std::uint64_t writer = 0;
  for (std::uint32_t i = 0; i < 3; ++i) {
    ASSERT_TRUE(sub.wait(hang_timeout));
    const auto sample = sub.take();
    const SampleInfo& info = sample.info();
    EXPECT_EQ(sample->height(), i);
    if (i > 0) {
      EXPECT_EQ(info.sequence, last + 1);
      EXPECT_EQ(info.writer, writer);
    }
    EXPECT_GE(info.source_stamp, before);
    EXPECT_GE(info.receive_stamp, info.source_stamp);
    EXPECT_LE(info.receive_stamp, std::chrono::system_clock::now());
    EXPECT_EQ(info.lost_before, 0U);
    last = info.sequence;
    writer = info.writer;
  }
}

TEST_P(PubSubTest, WhatDoesNotFitTheDepthIsLostOldestFirstAndCounted) {
  Node a = open("a");
  Node b = open("b");
  auto pub = a.publisher<PointCloud2>("points").value();
  auto sub = b.subscriber<PointCloud2, F::height>("points", {.depth = 4}).value();
  expect_served(pub, 1);
  pub.publish(cloud(0));
  ASSERT_TRUE(sub.wait(hang_timeout));
  (void)sub.take();
  auto watcher = b.subscriber<PointCloud2, F::height>("points", {.depth = 64}).value();
  expect_served(pub, 2);
  for (std::uint32_t i = 1; i <= 20; ++i) pub.publish(cloud(i));
  std::uint32_t seen = 0;
  while (seen < 20 && watcher.wait(hang_timeout)) {
    if (const auto sample = watcher.take()) seen = sample->height();
  }
  const auto first = sub.take();
  EXPECT_EQ(first->height(), 17U);
  EXPECT_EQ(first.info().lost_before, 16U);
  EXPECT_EQ(sub.status().lost, 16U);
}

TEST_P(PubSubTest, TakeLatestPassesOverOlderSamples) {
  Node a = open("a");
  Node b = open("b");
  auto pub = a.publisher<PointCloud2>("points").value();
  auto sub = b.subscriber<PointCloud2, F::height>("points").value();
  expect_served(pub, 1);
  for (std::uint32_t i = 1; i <= 5; ++i) pub.publish(cloud(i));
  std::uint32_t newest = 0;
  ASSERT_TRUE(eventually([&] {
    if (const auto sample = sub.take_latest()) newest = sample->height();
    return newest == 5;
  }));
  EXPECT_FALSE(sub.take_latest());
  EXPECT_EQ(sub.status().lost, 0U);
}

TEST_P(PubSubTest, WaitingEndsWithASampleOrWithTime) {
  Node a = open("a");
  Node b = open("b");
  auto pub = a.publisher<PointCloud2>("points").value();
  auto sub = b.subscriber<PointCloud2, F::height>("points").value();
  EXPECT_FALSE(sub.wait(10ms));
  expect_served(pub, 1);
  std::thread publisher([&] { pub.publish(cloud(1)); });
  EXPECT_TRUE(sub.wait(10s));
  publisher.join();
}

TEST_P(PubSubTest, ACallbackGetsEverySampleInOrderAndNoneAfterItsSubscriberIsGone) {
  Node a = open("a");
  Node b = open("b");
  auto pub = a.publisher<PointCloud2>("points").value();
  std::atomic<std::uint32_t> calls{0};
  std::atomic<std::uint32_t> disorder{0};
  {
    auto sub = b.subscriber<PointCloud2, F::height>("points",
                                                    [&](const auto& sample) {
                                                      disorder += sample->height() != calls ? 1 : 0;
                                                      ++calls;
                                                    },
                                                    {.depth = 64})
                   .value();
    expect_served(pub, 1);
    for (std::uint32_t i = 0; i < 50; ++i) pub.publish(cloud(i));
    EXPECT_TRUE(eventually([&] { return calls == 50; })) << calls;
  }
  EXPECT_EQ(disorder, 0U);
  for (std::uint32_t i = 0; i < 10; ++i) pub.publish(cloud(i));
  EXPECT_EQ(calls, 50U);
  expect_served(pub, 0);
}

TEST_P(PubSubTest, ASubscriberMayBeDestroyedInItsOwnCallback) {
  Node a = open("a");
  auto pub = a.publisher<PointCloud2>("points").value();
  std::atomic<bool> gone{false};
  // Orders the threads for the thread sanitizer, which cannot detect that messages over the network order
  // the threads.
  std::atomic<bool> complete{false};
  std::optional<Node> b = open("b");
  using Sub = Subscriber<PointCloud2, F::height>;
  std::optional<Sub> sub;
  sub.emplace(b->subscriber<PointCloud2, F::height>("points", [&](const auto&) {
                 if (!complete) return;
                 sub.reset();
                 gone = true;
               }).value());
  complete = true;
  b.reset();  // now only the subscriber keeps the node alive, and the callback destroys the last reference
  expect_served(pub, 1);
  pub.publish(cloud(1));
  EXPECT_TRUE(eventually([&] { return gone.load(); }));
  expect_served(pub, 0);
}

TEST_P(PubSubTest, ACallbackThatIsKnownToTakeLongHoldsUpNoOtherSubscriber) {
  Node a = open("a");
  Node b = open("b");
  auto slow_pub = a.publisher<PointCloud2>("slow").value();
  auto pub = a.publisher<PointCloud2>("points").value();
  std::atomic<int> calls{0};
  std::atomic<bool> may_return{false};
  auto slow = b.subscriber<PointCloud2, F::height>("slow", [&](const auto&) {
                 if (++calls == 1) return static_cast<void>(eventually([] { return false; }, 1ms));
                 eventually([&] { return may_return.load(); });
               }).value();
  auto sub = b.subscriber<PointCloud2, F::height>("points").value();
  expect_served(slow_pub, 1);
  expect_served(pub, 1);
  slow_pub.publish(cloud(1));
  slow_pub.publish(cloud(2));
  EXPECT_TRUE(eventually([&] { return calls == 2; }));
  pub.publish(cloud(3));
  EXPECT_TRUE(sub.wait(hang_timeout));
  may_return = true;
}

// The agent removes the subscriber, and also answers the questions of the callback to the node.
TEST_P(PubSubTest, ACallbackThatHasDestroyedItsSubscriberMayAskTheNode) {
  Node a = open("a");
  Node b = open("b");
  auto pub = a.publisher<PointCloud2>("points").value();
  std::atomic<std::size_t> topics{0};
  std::atomic<bool> complete{false};
  std::optional<Subscriber<PointCloud2, F::height>> sub;
  sub.emplace(b.subscriber<PointCloud2, F::height>("points", [&](const auto&) {
                 if (!complete) return;
                 sub.reset();
                 expect_served(pub, 0);  // this holds once the agent has removed the subscriber
                 topics = b.topics().size();
               }).value());
  complete = true;
  expect_served(pub, 1);
  pub.publish(cloud(1));
  EXPECT_TRUE(eventually([&] { return topics == 1; }));
}

TEST_P(PubSubTest, ASampleOutlivesItsSubscriberItsNodeAndItsPublisher) {
  std::optional<Node> a = open("a");
  std::optional<Node> b = open("b");
  std::optional pub = a->publisher<PointCloud2>("points").value();
  std::optional sub = b->subscriber<PointCloud2>("points").value();
  expect_served(*pub, 1);
  pub->publish(cloud(5, 100'000));
  ASSERT_TRUE(sub->wait(hang_timeout));
  const auto sample = sub->take();
  sub.reset();
  b.reset();
  pub.reset();
  a.reset();
  EXPECT_EQ(sample.to_owned(), cloud(5, 100'000));
}

TEST_P(PubSubTest, PublishersAndSubscribersJoinAndLeaveInAnyOrder) {
  Node a = open("a");
  Node b = open("b");
  for (int round = 0; round < 6; ++round) {
    std::optional<Publisher<PointCloud2>> pub;
    std::optional<Subscriber<PointCloud2, F::height>> sub;
    const auto open_pub = [&] { pub = a.publisher<PointCloud2>("points").value(); };
    const auto open_sub = [&] { sub.emplace(b.subscriber<PointCloud2, F::height>("points").value()); };
    if (round % 2 == 0) open_pub();
    open_sub();
    if (round % 2 == 1) open_pub();
    expect_served(*pub, 1);
    pub->publish(cloud(static_cast<std::uint32_t>(round)));
    ASSERT_TRUE(sub->wait(hang_timeout));
    const auto sample = sub->take();
    EXPECT_EQ(sample->height(), static_cast<std::uint32_t>(round));
    if (round % 3 == 0) {
      pub.reset();
      EXPECT_TRUE(eventually([&] { return sub->status().writers.empty(); }));
    } else {
      sub.reset();
      expect_served(*pub, 0);
    }
  }
}

TEST_P(PubSubTest, WhatAPublisherSentBeforeItWentCanStillBeTaken) {
  Node a = open("a");
  Node b = open("b");
  auto sub = b.subscriber<PointCloud2, F::height>("points").value();
  {
    auto pub = a.publisher<PointCloud2>("points").value();
    expect_served(pub, 1);
    for (std::uint32_t i = 1; i <= 5; ++i) pub.publish(cloud(i));
  }
  ASSERT_TRUE(eventually([&] { return sub.status().writers.empty(); }));
  std::uint32_t taken = 0;
  while (sub.wait(in_shared_memory() ? 0ms : 100ms) && sub.take()) ++taken;
  EXPECT_EQ(taken, 5U);
}

TEST_P(PubSubTest, SeveralWritersOfATopicAreHeardWithTheirOwnSequences) {
  Node a = open("a");
  Node b = open("b");
  Node c = open("c");
  auto first = a.publisher<PointCloud2>("points").value();
  auto second = c.publisher<PointCloud2>("points").value();
  auto sub = b.subscriber<PointCloud2, F::height>("points", {.depth = 32}).value();
  expect_served(first, 1);
  expect_served(second, 1);
  for (std::uint32_t i = 0; i < 10; ++i) {
    first.publish(cloud(i));
    second.publish(cloud(100 + i));
  }
  std::size_t taken = 0;
  while (taken < 20 && sub.wait(hang_timeout)) {
    while (sub.take()) ++taken;
  }
  EXPECT_EQ(taken, 20U);
  EXPECT_EQ(sub.status().lost, 0U);
  EXPECT_EQ(sub.status().writers.size(), 2U);
}

TEST_P(PubSubTest, APublisherAndASubscriberOfOneNodeHearEachOther) {
  Node node = open("both");
  auto pub = node.publisher<PointCloud2>("points").value();
  auto sub = node.subscriber<PointCloud2, F::width>("points").value();
  expect_served(pub, 1);
  pub.publish(cloud(1));
  ASSERT_TRUE(sub.wait(hang_timeout));
  const auto sample = sub.take();
  EXPECT_EQ(sample->width(), 2U);
}

INSTANTIATE_TEST_SUITE_P(Ways, PubSubTest, ::testing::Values(Way::shm, Way::udp, Way::udp_sockets), way_name);

}  // namespace
}  // namespace sft::test
