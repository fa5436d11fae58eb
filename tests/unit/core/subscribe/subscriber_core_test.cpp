// A subscriber with its two ports, its waiting threads and its callback. The order of samples between the
// ports is tested by intake_test.cpp.
#include "core/subscribe/subscriber_core.h"

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <limits>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <thread>
#include <utility>

#include "core/platform/clock.h"
#include "core/seam/buffer_pool.h"
#include "tests/support/heap_bytes.h"
#include "tests/unit/core/seam/queue_port.h"

namespace sft::core {
namespace {

using namespace detail;

using sensor_msgs::msg::PointCloud2;

class SubscriberCoreTest : public ::testing::Test {
 protected:
  SubscriberCoreTest() { reopen({}); }

  void reopen(untyped::Callback callback) {
    subscriber =
        std::make_unique<SubscriberCore>(SubscriberCore::Spec{.topic = "points",
                                                              .type = &type,
                                                              .feeds = {{.id = 1, .selection = type.full()}},
                                                              .options = {},
                                                              .callback = std::move(callback),
                                                              .callback_clock = &read_callback_time},
                                         bells->at(1), nullptr);
    subscriber->ports().set_memory(memory);
    subscriber->ports().set_network(network);
  }

  /// Opens a subscriber with that number of selections and without ports.
  void reopen_with(EndpointId selections) {
    SubscriberCore::Spec spec{
        .topic = "points", .type = &type, .feeds = {}, .options = {}, .callback = nullptr};
    for (EndpointId id = 1; id <= selections; ++id)
      spec.feeds.push_back({.id = id, .selection = type.full()});
    subscriber = std::make_unique<SubscriberCore>(std::move(spec), bells->at(1), nullptr);
  }

  void arrives(Queue& port, std::uint64_t sequence, EndpointId writer = 9) {
    arrives(port, sequence, writer, static_cast<std::int64_t>(sequence));
  }
  void arrives(Queue& port, std::uint64_t sequence, EndpointId writer, std::int64_t stamp_ns) {
    SampleHandle sample = pool->take(256);
    sample->writer = writer;
    sample->sequence = sequence;
    sample->source_stamp_ns = stamp_ns;
    sample->mask = type.full();
    port.samples.push_back(std::move(sample));
  }

  /// Delivers a sample through shared memory. The sample names an earlier one that went by UDP.
  void arrives_after_diverted(std::uint64_t sequence, std::uint64_t diverted, std::int64_t diverted_at_ns) {
    arrives(*memory, sequence);
    memory->samples.back()->diverted_sequence = diverted;
    memory->samples.back()->diverted_stamp_ns = diverted_at_ns;
  }

  std::vector<std::uint64_t> taken() {
    std::vector<std::uint64_t> sequences;
    while (const untyped::Sample sample = subscriber->take()) sequences.push_back(sample.info().sequence);
    return sequences;
  }

  static Time read_callback_time() { return callback_time; }

  using Sequences = std::vector<std::uint64_t>;
  static inline Time callback_time{};  ///< a test must advance this time itself
  const TypeSupport type{TypeTable<PointCloud2>::type};
  const std::unique_ptr<DoorbellPage> bells = DoorbellPage::create();
  const std::shared_ptr<BufferPool> pool = BufferPool::make(1 << 20);
  const std::shared_ptr<MemoryQueue> memory = std::make_shared<MemoryQueue>();
  const std::shared_ptr<NetworkQueue> network = std::make_shared<NetworkQueue>();
  std::unique_ptr<SubscriberCore> subscriber;
};

TEST_F(SubscriberCoreTest, RemembersAFewOfItsFormerRequestsHoweverManyItMakes) {
  const Selection one = FieldMask(type.full()), other = FieldMask(type.closed(type.none()));
  std::uint64_t sequence = 0;
  const auto ask = [&] {
    ++sequence;
    subscriber->feed().requests(sequence % 2 == 0 ? one : other, sequence);
  };
  EXPECT_LT(sft::test::bytes_left_by(ask), sft::test::nothing_left);
  EXPECT_EQ(subscriber->feed().status().requests, sequence);
}

TEST_F(SubscriberCoreTest, ARequestOfWhichOnlyTheNumberChangesAsksForTheSame) {
  const Selection before = subscriber->feed().status().selection;
  subscriber->ports().requests(nullptr, 7);
  EXPECT_EQ(subscriber->feed().status().requests, 7U);
  EXPECT_EQ(subscriber->feed().status().selection, before);
}

TEST_F(SubscriberCoreTest, SamplesOfBothPathsComeInTheOrderOfTheirWriter) {
  arrives(*network, 1);
  arrives(*memory, 2);
  arrives(*network, 3);
  EXPECT_EQ(taken(), (Sequences{1, 2, 3}));
}

TEST_F(SubscriberCoreTest, ASampleInSharedMemoryWaitsForOneBeforeItThatWentByUdp) {
  arrives(*memory, 1);
  arrives_after_diverted(3, 2, realtime_ns());
  EXPECT_EQ(taken(), (Sequences{1}));
  EXPECT_FALSE(subscriber->available());
  arrives(*network, 7, 8);  // a sample of another writer
  EXPECT_EQ(taken(), (Sequences{7}));
  arrives(*network, 2);
  EXPECT_EQ(taken(), (Sequences{2, 3}));
  EXPECT_EQ(subscriber->feed().status().lost, 0U);
}

TEST_F(SubscriberCoreTest, WhatWentByUdpToOthersIsNotWaitedForWhereNobodyListensThere) {
  network->is_connected = false;
  arrives(*memory, 1);
  arrives_after_diverted(3, 2, realtime_ns());
  EXPECT_EQ(taken(), (Sequences{1, 3}));
  subscriber->ports().set_network(nullptr);
  arrives_after_diverted(5, 4, realtime_ns());
  EXPECT_EQ(taken(), (Sequences{5}));
}

TEST_F(SubscriberCoreTest, OneThatWaitsInVainIsLookedAtAgain) {
  arrives_after_diverted(2, 1, realtime_ns());
  EXPECT_FALSE(subscriber->wait({}));
  std::jthread agent([&](const std::stop_token& end) {
    while (!end.stop_requested()) {
      if (subscriber->ports().take_held_back()) subscriber->wake();
    }
  });
  EXPECT_TRUE(subscriber->wait(std::chrono::seconds(10)));
  EXPECT_EQ(taken(), (Sequences{2}));
}

TEST_F(SubscriberCoreTest, WhatItsWriterSentBeforeIsFoundInSharedMemoryBehindSamplesOfOthers) {
  arrives(*memory, 1, 8, 100);
  arrives(*memory, 1, 9, 5);
  arrives(*memory, 2, 9, 6);
  arrives(*network, 3, 9, 7);
  EXPECT_EQ(taken(), (Sequences{1, 2, 3, 1}));
  EXPECT_EQ(subscriber->feed().status().lost, 0U);
}

TEST_F(SubscriberCoreTest, WhatAPortLostUnseenIsCountedAlsoWhenThePortIsGone) {
  memory->unnoticed = 5;
  EXPECT_EQ(subscriber->feed().status().lost, 5U);
  subscriber->ports().set_memory(nullptr);
  EXPECT_EQ(subscriber->feed().status().lost, 5U);
}

TEST_F(SubscriberCoreTest, CountsAreThoseOfAllPortsWhicheverComeAndGo) {
  SubscriberPorts& ports = subscriber->ports();
  const auto expect_counts = [&](std::uint64_t lost, std::uint64_t discarded, std::uint64_t held_too_many) {
    const SubscriberStatus status = subscriber->feed().status();
    EXPECT_EQ(status.lost, lost);
    EXPECT_EQ(status.discarded, discarded);
    EXPECT_EQ(status.held_too_many, held_too_many);
    EXPECT_EQ(ports.held_too_many(), held_too_many) << "events report this count";
  };
  expect_counts(0, 0, 0);
  memory->unnoticed = 1, memory->discarded = 2, memory->at_limit = 3;
  network->unnoticed = 10, network->discarded = 20;
  expect_counts(11, 22, 3);
  ports.lose_memory();
  expect_counts(11, 22, 3);
  const auto next = std::make_shared<MemoryQueue>();
  next->unnoticed = 100, next->discarded = 200, next->at_limit = 300;
  ports.set_memory(next);
  expect_counts(111, 222, 303);
  ports.lose_memory();
  expect_counts(111, 222, 303);
  EXPECT_TRUE(ports.release_lost_memory(true));
  ports.set_network(nullptr);
  expect_counts(111, 222, 303);
}

TEST_F(SubscriberCoreTest, TheAccountOfAWriterHasWhatWasDiscardedBeforeItsFirstSampleAndItsGaps) {
  SubscriberPorts& ports = subscriber->ports();
  const auto inlet = std::make_shared<VanillaInlet>(type, 2, 0);
  ports.set_vanilla(inlet);
  const auto comes = [&](std::uint64_t sequence) {
    SampleHandle sample = pool->take(256);
    sample->header().body_bytes = 1;
    inlet->put({.writer = 5,
                .sequence = sequence,
                .source_stamp_ns = static_cast<std::int64_t>(sequence),
                .sample = sample});
  };
  const auto expect_account = [&](std::uint64_t received, std::uint64_t lost) {
    const DomainSnapshot::Received account = ports.account_of(5);
    EXPECT_EQ(account.received, received);
    EXPECT_EQ(account.lost, lost);
  };
  expect_account(0, 0);
  EXPECT_EQ(ports.arrivals(5), 0U);
  for (const std::uint64_t sequence : {1, 2, 3}) comes(sequence);
  EXPECT_EQ(ports.arrivals(5), 3U);
  expect_account(0, 1);
  EXPECT_EQ(taken(), (Sequences{2, 3}));
  expect_account(2, 1);
  comes(6);
  EXPECT_EQ(taken(), (Sequences{6}));
  expect_account(3, 3);
  EXPECT_EQ(ports.losses(), 2U) << "events report what the gaps show";
  const SubscriberStatus status = subscriber->feed().status();
  EXPECT_EQ(status.received, 3U);
  EXPECT_EQ(status.lost, 3U);
  EXPECT_EQ(status.discarded, 1U);
  EXPECT_EQ(ports.account_of(6), DomainSnapshot::Received{});
}

TEST_F(SubscriberCoreTest, WhatCameBeforeTheMemoryWasLostIsTakenBeforeWhatComesByTheNextPort) {
  const auto next = std::make_shared<MemoryQueue>();
  arrives(*memory, 1);
  arrives(*memory, 2, 8, 100);
  arrives(*memory, 2);
  subscriber->ports().lose_memory();
  subscriber->ports().set_memory(next);
  arrives(*network, 3);
  arrives(*next, 4);
  EXPECT_EQ(taken(), (Sequences{1, 2, 3, 2, 4}));
  EXPECT_EQ(subscriber->feed().status().lost, 0U);
}

TEST_F(SubscriberCoreTest, ALostPortIsKeptUntilNothingWaitsInItOrAnotherOneIsLost) {
  SubscriberPorts& ports = subscriber->ports();
  auto first = std::make_shared<MemoryQueue>();
  const std::weak_ptr<MemoryQueue> kept = first;
  ports.set_memory(first);
  arrives(*first, 1);
  arrives(*first, 2);
  first->unnoticed = 5;
  first.reset();
  ports.lose_memory();
  ports.set_memory(memory);
  EXPECT_FALSE(ports.release_lost_memory(false)) << "two samples wait";
  EXPECT_EQ(subscriber->feed().status().lost, 5U);
  EXPECT_EQ(taken(), (Sequences{1, 2}));
  EXPECT_FALSE(kept.expired());
  EXPECT_TRUE(ports.release_lost_memory(false));
  EXPECT_TRUE(kept.expired());
  EXPECT_EQ(subscriber->feed().status().lost, 5U);

  arrives(*memory, 3);
  ports.lose_memory();
  EXPECT_FALSE(ports.release_lost_memory(false));
  ports.set_memory(std::make_shared<MemoryQueue>());
  ports.lose_memory();
  EXPECT_EQ(taken(), (Sequences{})) << "the port that was lost before has gone";
}

TEST_F(SubscriberCoreTest, WhatWaitsInALostPortGoesWhenItsTimeIsOver) {
  arrives(*memory, 1);
  subscriber->ports().lose_memory();
  EXPECT_TRUE(subscriber->ports().release_lost_memory(true));
  EXPECT_EQ(taken(), (Sequences{}));
}

TEST_F(SubscriberCoreTest, FormerConditionsCountUntilNoSampleWaitsNotEvenOneThatCannotBeTakenYet) {
  const auto request = [&](const char* text, std::uint64_t number) {
    subscriber->feed().requests(type.closed(type.parse_selection(text).value()), number);
  };
  arrives(*memory, 1);
  EXPECT_EQ(taken(), (Sequences{1}));
  request("* @ height > 5", 2);
  request("*", 3);
  arrives(*memory, 4);
  memory->is_at_limit = true;
  subscriber->ports().forget_former_conditions();
  EXPECT_EQ(taken(), (Sequences{}));
  memory->is_at_limit = false;
  EXPECT_EQ(taken(), (Sequences{4}));
  EXPECT_EQ(subscriber->feed().status().lost, 0U) << "the conditions in between may have withheld samples";
  arrives(*memory, 6);
  EXPECT_EQ(taken(), (Sequences{6}));
  EXPECT_EQ(subscriber->feed().status().lost, 0U) << "the fifth one may be of the time when they counted";
  arrives(*memory, 8);
  EXPECT_EQ(taken(), (Sequences{8}));
  EXPECT_EQ(subscriber->feed().status().lost, 1U) << "nothing waited any more, so they count no more";
}

TEST_F(SubscriberCoreTest, LossesThatOnlyAPortKnowsAreCountedWithThoseSeen) {
  arrives(*network, 5);
  arrives(*network, 8);
  network->unnoticed = 3;
  taken();
  EXPECT_EQ(subscriber->feed().status().lost, 5U);
}

TEST_F(SubscriberCoreTest, WhetherASampleIsExpiredIsToldOfAnyStamp) {
  constexpr std::int64_t first = std::numeric_limits<std::int64_t>::min();
  constexpr std::int64_t last = std::numeric_limits<std::int64_t>::max();
  for (const std::int64_t lifespan : {std::int64_t{1}, std::int64_t{60'000'000'000}, last}) {
    reopen({});
    Hearing hearing;
    hearing.source.writer = hearing.status.id = 9;
    hearing.offered.lifespan = std::chrono::nanoseconds(lifespan);
    subscriber->ports().hears({hearing});
    arrives(*network, 1, 9, first);
    arrives(*network, 2, 9, last);
    EXPECT_EQ(taken(), (Sequences{2})) << lifespan;
    EXPECT_EQ(subscriber->feed().status().expired, 1U) << lifespan;
  }
}

TEST_F(SubscriberCoreTest, AMaximumRateIsKeptWithAnyStamps) {
  ASSERT_TRUE(subscriber->feed().set_max_rate_hz(100'000));
  std::uint64_t sequence = 0;
  for (int round = 0; round < 3; ++round) {
    for (const std::int64_t stamp : {std::numeric_limits<std::int64_t>::min(), std::int64_t{-1},
                                     std::int64_t{0}, std::numeric_limits<std::int64_t>::max()}) {
      arrives(*memory, ++sequence, 9, stamp);
    }
  }
  const std::size_t delivered = taken().size();
  EXPECT_GT(delivered, 0U);
  EXPECT_EQ(delivered + subscriber->feed().status().withheld, sequence);
}

TEST_F(SubscriberCoreTest, TheLatestSampleCarriesTheLossesOfThosePassedOver) {
  arrives(*network, 1);
  arrives(*network, 3);
  arrives(*network, 4);
  const untyped::Sample latest = subscriber->take_latest();
  EXPECT_EQ(latest.info().sequence, 4U);
  EXPECT_EQ(latest.info().lost_before, 1U);
  EXPECT_FALSE(subscriber->take_latest());
}

TEST_F(SubscriberCoreTest, APublisherThatWaitsIsToldOfRoomHoweverSamplesAreTaken) {
  Hearing waiting;
  waiting.memory = true;
  waiting.source = {.writer = 9, .reliable = true, .waits = true};
  subscriber->ports().hears({waiting});
  arrives(*memory, 1);
  EXPECT_TRUE(subscriber->take());
  EXPECT_EQ(memory->told_of_room, 1);
  arrives(*memory, 2);
  EXPECT_TRUE(subscriber->take_latest());
  EXPECT_EQ(memory->told_of_room, 2);
  waiting.source.waits = false;
  subscriber->ports().hears({waiting});
  EXPECT_FALSE(subscriber->take());
  EXPECT_EQ(memory->told_of_room, 2) << "nobody waits any more";
}

TEST_F(SubscriberCoreTest, WaitReturnsAtOnceIfThereIsASampleAndAtTheDeadlineIfNot) {
  EXPECT_FALSE(subscriber->wait(std::chrono::milliseconds(5)));
  arrives(*memory, 1);
  EXPECT_TRUE(subscriber->wait(std::chrono::hours(1)));
}

TEST_F(SubscriberCoreTest, ACallbackGetsAllThatArrived) {
  Sequences called;
  reopen([&](untyped::Sample&& sample) { called.push_back(sample.info().sequence); });
  arrives(*network, 1);
  arrives(*memory, 2);
  subscriber->arrived();
  EXPECT_EQ(called, (Sequences{1, 2}));
}

TEST_F(SubscriberCoreTest, ASampleThatArrivesDuringACallbackIsCalledBackForAfterwards) {
  Sequences called;
  bool inside = false;
  reopen([&](untyped::Sample&& sample) {
    EXPECT_FALSE(inside);
    inside = true;
    called.push_back(sample.info().sequence);
    if (called.size() == 1) {
      arrives(*network, 2);
      subscriber->arrived();
    }
    inside = false;
  });
  arrives(*network, 1);
  subscriber->arrived();
  EXPECT_EQ(called, (Sequences{1, 2}));
}

TEST_F(SubscriberCoreTest, AClosedSubscriberCallsNobody) {
  int calls = 0;
  reopen([&](untyped::Sample&&) {
    ++calls;
    subscriber->close();  // returns at once, since it is called within the callback
  });
  arrives(*network, 1);
  arrives(*network, 2);
  subscriber->arrived();
  EXPECT_EQ(calls, 1);
}

// The transport's thread must not be delayed a second time.
TEST_F(SubscriberCoreTest, AfterASlowCallbackTheDispatcherCallsBackUntilManyWereQuick) {
  int calls = 0;
  reopen([&](untyped::Sample&&) {
    if (++calls == 1) callback_time += std::chrono::milliseconds(1);
  });
  auto arrive_together = [&, sequence = std::uint64_t{0}](int count) mutable {
    for (int i = 0; i < count; ++i) arrives(*network, ++sequence);
    subscriber->arrived();
  };
  arrive_together(101);
  EXPECT_EQ(calls, 1);
  EXPECT_TRUE(subscriber->waits_for_dispatch());
  subscriber->dispatch();
  EXPECT_EQ(calls, 101);
  arrive_together(1);
  EXPECT_EQ(calls, 102);
}

// A subscriber with two selections.
class TwoFeedsTest : public SubscriberCoreTest {
 protected:
  /// The number of a selection, and a sequence.
  using Came = std::vector<std::pair<std::uint32_t, std::uint64_t>>;

  TwoFeedsTest() {
    reopen_with(2);
    subscriber->ports(0).set_memory(memory);
    subscriber->ports(1).set_memory(memory_of_second);
  }
  template <class Take>
  static Came all(Take take) {
    Came came;
    while (const untyped::Sample sample = take())
      came.emplace_back(sample.info().selection, sample.info().sequence);
    return came;
  }

  const std::shared_ptr<MemoryQueue> memory_of_second = std::make_shared<MemoryQueue>();
};

TEST_F(TwoFeedsTest, TheOldestSampleComesFirstAndOfEquallyOldOnesThatOfTheFirstSelection) {
  arrives(*memory_of_second, 1);
  arrives(*memory_of_second, 3);
  arrives(*memory, 2);
  arrives(*memory, 3);
  EXPECT_EQ(all([&] { return subscriber->take(); }), (Came{{1, 1}, {0, 2}, {0, 3}, {1, 3}}));
  EXPECT_EQ(subscriber->feed(0).status().received, 2U);
  EXPECT_EQ(subscriber->feed(1).status().received, 2U);
}

TEST_F(TwoFeedsTest, TheNewestSampleOfEachSelectionIsTakenInTurn) {
  for (const std::uint64_t sequence : {1, 2, 3, 4}) arrives(*memory, sequence);
  arrives(*memory_of_second, 2);
  EXPECT_EQ(all([&] { return subscriber->take_latest(); }), (Came{{0, 4}, {1, 2}}));
}

TEST_F(TwoFeedsTest, LossesAreThoseOfTheSelection) {
  arrives(*memory, 1);
  arrives(*memory, 4);
  arrives(*memory_of_second, 1);
  arrives(*memory_of_second, 2);
  EXPECT_EQ(all([&] { return subscriber->take(); }).size(), 4U);
  EXPECT_EQ(subscriber->feed(0).status().lost, 2U);
  EXPECT_EQ(subscriber->feed(1).status().lost, 0U);
}

TEST_F(TwoFeedsTest, AnotherSelectionOfTheSecondLeavesTheFirst) {
  ASSERT_TRUE(subscriber->feed(1).set_selection(FieldMask(PointCloud2::Field::width)));
  EXPECT_EQ(subscriber->feed(0).required(), Selection(type.full()));
  EXPECT_EQ(subscriber->feed(1).required(), Selection(FieldMask(PointCloud2::Field::width)));
  ASSERT_TRUE(subscriber->feed(1).set_max_rate_hz(10));
  EXPECT_EQ(subscriber->ports(0).min_period_us(), 0U);
  EXPECT_EQ(subscriber->ports(1).min_period_us(), 100'000U);
  EXPECT_EQ(subscriber->find(2).error().code, Errc::invalid_argument);
}

TEST_F(TwoFeedsTest, AThreadThatWaitsIsWokenBySamplesOfEither) {
  const std::array ports{std::make_shared<SharedMemoryQueue>(), std::make_shared<SharedMemoryQueue>()};
  for (const std::size_t i : {0, 1}) subscriber->ports(i).set_memory(ports[i]);
  for (const std::size_t i : {0, 1}) {
    std::thread waits([&] { EXPECT_TRUE(subscriber->wait(std::chrono::hours(1))); });
    SampleHandle sample = pool->take(256);
    sample->writer = 9;
    sample->sequence = 1;
    ports[i]->put(std::move(sample));
    subscriber->arrived();
    waits.join();
    EXPECT_EQ(subscriber->take().info().selection, i);
    EXPECT_FALSE(subscriber->available());
  }
}

TEST_F(TwoFeedsTest, AWriterWhoseClockIsAheadIsHeardBesideOneThatAlwaysHasANextSample) {
  for (std::uint64_t sequence = 1; sequence <= 30; ++sequence) arrives(*memory, sequence);
  arrives(*memory_of_second, 1, 8, 1'000'000);
  const Came came = all([&] { return subscriber->take(); });
  const auto place = std::ranges::find(came, 1U, &Came::value_type::first) - came.begin();
  EXPECT_EQ(place, 16);
}

TEST_F(TwoFeedsTest, ASelectionThatWasPassedOverChangesNoOrderOfTheSamplesOfAWriter) {
  for (std::uint64_t sequence = 1; sequence <= 30; ++sequence) arrives(*memory, sequence);
  arrives(*memory_of_second, 31);
  EXPECT_EQ(all([&] { return subscriber->take(); }).back(), (std::pair<std::uint32_t, std::uint64_t>{1, 31}));
}

class ThreeFeedsTest : public SubscriberCoreTest {
 protected:
  ThreeFeedsTest() {
    reopen_with(3);
    for (const std::size_t i : {0, 1, 2}) subscriber->ports(i).set_memory(queues[i]);
  }
  /// Takes a sample, and returns its selection.
  std::uint32_t take() { return subscriber->take().info().selection; }

  const std::array<std::shared_ptr<MemoryQueue>, 3> queues{
      std::make_shared<MemoryQueue>(), std::make_shared<MemoryQueue>(), std::make_shared<MemoryQueue>()};
};

TEST_F(ThreeFeedsTest, ASelectionThatWasPassedOverHidesNoOtherOneWithSamplesOfAnotherWriter) {
  for (std::uint64_t sequence = 1; sequence <= 40; ++sequence) arrives(*queues[0], sequence);
  arrives(*queues[2], 100);
  take();
  arrives(*queues[1], 1, 8, 1'000'000);
  for (std::uint32_t i = 1; i <= passed_over_max; ++i) EXPECT_EQ(take(), 0U) << i;
  EXPECT_EQ(take(), 1U);
}

TEST_F(ThreeFeedsTest, ASelectionThatWasPassedOverLetsEarlierSamplesOfItsWriterGoFirst) {
  for (std::uint64_t sequence = 1; sequence <= 40; ++sequence) arrives(*queues[0], sequence, 8);
  arrives(*queues[1], 2, 9, 2'000'000);
  take();
  arrives(*queues[2], 1, 9, 1'000'000);
  for (std::uint32_t i = 1; i < passed_over_max; ++i) EXPECT_EQ(take(), 0U) << i;
  EXPECT_EQ(take(), 2U) << "that of the second selection is due, and comes after it";
}

// The publisher's clock was set back between the two samples.
TEST_F(TwoFeedsTest, TheSamplesOfAWriterComeInTheOrderOfTheirNumbers) {
  arrives(*memory, 1, 9, 1000);
  arrives(*memory_of_second, 2, 9, 500);
  EXPECT_EQ(all([&] { return subscriber->take(); }), (Came{{0, 1}, {1, 2}}));
}

TEST_F(TwoFeedsTest, EachSampleIsTakenByOneOfSeveralThreads) {
  constexpr std::uint64_t samples = 2000;
  const std::array ports{std::make_shared<SharedMemoryQueue>(), std::make_shared<SharedMemoryQueue>()};
  for (const std::size_t i : {0, 1}) subscriber->ports(i).set_memory(ports[i]);
  std::array<std::atomic<std::uint64_t>, 2> taken{};
  const auto take_all = [&] {
    while (taken[0] + taken[1] < 2 * samples) {
      if (const untyped::Sample sample = subscriber->take()) ++taken[sample.info().selection];
    }
  };
  std::jthread first(take_all), second(take_all);
  for (std::uint64_t sequence = 1; sequence <= samples; ++sequence) {
    for (const auto& port : ports) {
      SampleHandle sample = pool->take(256);
      for (; !sample; sample = pool->take(256)) std::this_thread::yield();
      sample->writer = 9;
      sample->sequence = sequence;
      sample->mask = type.full();
      port->put(std::move(sample));
    }
  }
  first.join();
  second.join();
  for (const std::size_t i : {0, 1}) EXPECT_EQ(subscriber->feed(i).status().received, samples) << i;
}

}  // namespace
}  // namespace sft::core
