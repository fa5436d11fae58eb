// Samples of DDS writers are queued for their subscriber, up to the limits that the subscriber requests.
#include "core/subscribe/vanilla_inlet.h"

#include <gmock/gmock.h>

#include <sensor_msgs/msg/PointCloud2.hpp>
#include <vector>

#include "core/platform/clock.h"
#include "core/seam/buffer_pool.h"
#include "tests/support/encoded.h"

namespace sft::core {
namespace {

using sensor_msgs::msg::PointCloud2;
using testing::ElementsAre;
using testing::IsEmpty;

class VanillaInletTest : public testing::Test {
 protected:
  explicit VanillaInletTest(std::uint32_t depth = 3, std::uint64_t depth_bytes = 0)
      : inlet(type, depth, depth_bytes) {}

  /// A whole sample with that height, as a thread that receives makes it.
  SampleHandle whole(std::uint32_t height, std::size_t data_bytes = 0) {
    PointCloud2 message;
    message.height = height;
    message.data.resize(data_bytes);
    sft::test::Encoded encoded(message);
    const detail::SampleLayout layout(type.index_slots());
    SampleHandle sample = pool->take(layout.bytes(encoded.bytes().size()));
    sample->mask = type.full();
    sample->header().body_bytes = static_cast<std::uint32_t>(encoded.bytes().size());
    std::ranges::copy(encoded.bytes(), sample->data + layout.body_offset);
    std::copy_n(encoded.index(), type.index_slots(), sample->index());
    return sample;
  }
  bool comes(std::uint64_t sequence, EndpointId writer = 1, std::uint32_t height = 0) {
    return inlet.put({.writer = writer,
                      .sequence = sequence,
                      .source_stamp_ns = static_cast<std::int64_t>(sequence) * 1'000'000,
                      .sample = whole(height == 0 ? static_cast<std::uint32_t>(sequence) : height)});
  }
  void ask(const char* selection, std::uint32_t min_period_us = 0) {
    inlet.ask(type.closed(type.parse_selection(selection).value()).without_rate(), min_period_us);
  }
  std::vector<std::uint64_t> taken() {
    std::vector<std::uint64_t> sequences;
    while (const SampleHandle sample = inlet.take()) sequences.push_back(sample->sequence);
    return sequences;
  }

  const TypeSupport& type = type_support<PointCloud2>();
  const std::shared_ptr<BufferPool> pool = BufferPool::make(1 << 20);
  VanillaInlet inlet;
};

TEST_F(VanillaInletTest, SamplesOfAllWritersAreTakenAsTheyCameEachWithItsOrigin) {
  EXPECT_TRUE(comes(7, 1));
  EXPECT_TRUE(comes(3, 2));
  EXPECT_TRUE(comes(8, 1));
  const SampleHandle first = inlet.take();
  EXPECT_EQ(first->writer, 1U);
  EXPECT_EQ(first->sequence, 7U);
  EXPECT_EQ(first->source_stamp_ns, 7'000'000);
  EXPECT_THAT(taken(), ElementsAre(3, 8));
  EXPECT_EQ(inlet.arrivals(1), 2U);
  EXPECT_EQ(inlet.arrivals(2), 1U);
}

TEST_F(VanillaInletTest, TheOldestSamplesOfAWriterAreDiscardedAndCounted) {
  for (std::uint64_t i = 1; i <= 5; ++i) EXPECT_TRUE(comes(i, 1));
  EXPECT_TRUE(comes(1, 2));
  EXPECT_THAT(taken(), ElementsAre(3, 4, 5, 1));
  EXPECT_EQ(inlet.counters().discarded, 2U);
  EXPECT_EQ(inlet.counters().lost_unnoticed, 2U) << "nothing was taken before them";
}

TEST_F(VanillaInletTest, SamplesThatCannotBeReadAreLostIfTheyComeBeforeTheFirstOne) {
  for (std::uint64_t i = 1; i <= 3; ++i) EXPECT_FALSE(inlet.put({.writer = 1, .sequence = i}));
  EXPECT_TRUE(comes(4, 1));
  EXPECT_THAT(taken(), ElementsAre(4));
  EXPECT_EQ(inlet.counters().discarded, 3U);
  EXPECT_EQ(inlet.counters().lost_unnoticed, 3U);
  EXPECT_FALSE(inlet.put({.writer = 1, .sequence = 5}));
  EXPECT_TRUE(comes(6, 1));
  EXPECT_THAT(taken(), ElementsAre(6));
  EXPECT_EQ(inlet.counters().lost_unnoticed, 3U) << "the gap in the sequence shows this one";
}

TEST_F(VanillaInletTest, OnlyWhatIsDiscardedBeforeTheFirstSampleIsLostUnnoticed) {
  for (std::uint64_t i = 1; i <= 5; ++i) EXPECT_TRUE(comes(i));
  EXPECT_EQ(inlet.lost_before_first(1), 2U) << "it is known before anything is taken";
  EXPECT_EQ(inlet.counters().lost_unnoticed, 0U);
  EXPECT_EQ(inlet.take()->sequence, 3U);
  for (std::uint64_t i = 6; i <= 9; ++i) EXPECT_TRUE(comes(i));
  EXPECT_THAT(taken(), ElementsAre(7, 8, 9));
  EXPECT_EQ(inlet.counters().discarded, 5U);
  EXPECT_EQ(inlet.counters().lost_unnoticed, 2U) << "the gap in the sequence shows the later ones";
  EXPECT_EQ(inlet.lost_before_first(1), 2U);
  EXPECT_EQ(inlet.lost_before_first(2), 0U);
}

TEST_F(VanillaInletTest, WhatCannotBeReadBetweenSamplesThatAreDiscardedIsLostWithThem) {
  EXPECT_TRUE(comes(1));
  EXPECT_FALSE(inlet.put({.writer = 1, .sequence = 2}));
  for (std::uint64_t i = 3; i <= 5; ++i) EXPECT_TRUE(comes(i));
  EXPECT_THAT(taken(), ElementsAre(3, 4, 5));
  EXPECT_EQ(inlet.counters().discarded, 2U);
  EXPECT_EQ(inlet.counters().lost_unnoticed, 2U);
}

TEST_F(VanillaInletTest, WhatNoLaterSampleOfAWriterThatHasGoneShowsIsLost) {
  EXPECT_FALSE(inlet.put({.writer = 1, .sequence = 1})) << "nothing else comes of it";
  EXPECT_TRUE(comes(1, 2));
  EXPECT_THAT(taken(), ElementsAre(1));
  EXPECT_FALSE(inlet.put({.writer = 2, .sequence = 2}));
  EXPECT_TRUE(comes(1, 3));
  EXPECT_FALSE(inlet.put({.writer = 3, .sequence = 2}));
  EXPECT_EQ(inlet.counters().lost_unnoticed, 0U);
  inlet.forget_others_than({});
  EXPECT_EQ(inlet.counters().lost_unnoticed, 2U);
  EXPECT_THAT(taken(), ElementsAre(1));
  EXPECT_EQ(inlet.counters().lost_unnoticed, 3U) << "at once, since nothing else may change any more";
  EXPECT_EQ(inlet.counters().discarded, 3U);
  inlet.forget_others_than({});
  EXPECT_EQ(inlet.counters().lost_unnoticed, 3U) << "it counts once";
}

TEST_F(VanillaInletTest, WhatIsDiscardedOfAWriterThatHasGoneAfterItsFirstSampleWasTakenIsLost) {
  EXPECT_TRUE(comes(1, 1));
  EXPECT_THAT(taken(), ElementsAre(1));
  EXPECT_TRUE(comes(2, 1));
  for (std::uint64_t i = 11; i <= 13; ++i) EXPECT_TRUE(comes(i, 2));
  inlet.forget_others_than({});
  EXPECT_EQ(inlet.counters().discarded, 1U) << "three wait of all";
  EXPECT_EQ(inlet.counters().lost_unnoticed, 1U);
  EXPECT_THAT(taken(), ElementsAre(11, 12, 13));
  inlet.forget_others_than({});
  EXPECT_EQ(inlet.counters().lost_unnoticed, 1U);
}

class VanillaInletBytesTest : public VanillaInletTest {
 protected:
  VanillaInletBytesTest() : VanillaInletTest(100, 2500) {}
};

TEST_F(VanillaInletBytesTest, TheBytesThatWaitAreLimitedButTheNewestSampleStays) {
  for (std::uint64_t i = 1; i <= 3; ++i) inlet.put({.writer = 1, .sequence = i, .sample = whole(1, 1000)});
  EXPECT_THAT(taken(), ElementsAre(2, 3));
  inlet.put({.writer = 1, .sequence = 4, .sample = whole(1, 9000)});
  EXPECT_THAT(taken(), ElementsAre(4));
}

TEST_F(VanillaInletBytesTest, WhatWasTakenIsRoomForOthers) {
  for (std::uint64_t i = 1; i < 10; i += 2) {
    inlet.put({.writer = 1, .sequence = i, .sample = whole(1, 1000)});
    inlet.put({.writer = 1, .sequence = i + 1, .sample = whole(1, 1000)});
    EXPECT_THAT(taken(), ElementsAre(i, i + 1));
  }
}

TEST_F(VanillaInletBytesTest, TheBytesOfAllWritersThatHaveGoneAreLimitedTogether) {
  for (EndpointId writer = 1; writer <= 5; ++writer)
    inlet.put({.writer = writer, .sequence = writer, .sample = whole(1, 1000)});
  inlet.forget_others_than({});
  EXPECT_THAT(taken(), ElementsAre(4, 5));
}

TEST_F(VanillaInletTest, WhatCameToAnEarlierReaderDoesNotComeAgain) {
  EXPECT_TRUE(comes(1));
  EXPECT_TRUE(comes(2));
  EXPECT_FALSE(comes(1));
  EXPECT_FALSE(comes(2));
  EXPECT_TRUE(comes(3));
  EXPECT_THAT(taken(), ElementsAre(1, 2, 3));
  EXPECT_EQ(inlet.arrivals(1), 3U);
  EXPECT_EQ(inlet.counters().discarded, 0U);
}

TEST_F(VanillaInletTest, AWriterThatRestartsUnderItsOldNameIsHeardFromItsFirstSample) {
  const auto comes_at = [&](std::int64_t stamp_ns, std::uint64_t sequence) {
    return inlet.put({.writer = 1, .sequence = sequence, .source_stamp_ns = stamp_ns, .sample = whole(1)});
  };
  EXPECT_TRUE(comes_at(1000, 41));
  EXPECT_TRUE(comes_at(2000, 42));
  EXPECT_FALSE(comes_at(1000, 41)) << "it is retained";
  EXPECT_FALSE(comes_at(0, 1)) << "it may be retained";
  EXPECT_TRUE(comes_at(3000, 1));
  EXPECT_TRUE(comes_at(4000, 2));
  EXPECT_FALSE(comes_at(3000, 1));
  EXPECT_THAT(taken(), ElementsAre(42, 1, 2));
}

TEST_F(VanillaInletTest, ASampleWithoutAStampHasTheTimeOfItsArrival) {
  const std::int64_t before = realtime_ns();
  EXPECT_TRUE(inlet.put({.writer = 1, .sequence = 1, .source_stamp_ns = -1, .sample = whole(1)}));
  const SampleHandle sample = inlet.take();
  EXPECT_GE(sample->source_stamp_ns, before);
  EXPECT_EQ(sample->source_stamp_ns, sample->receive_stamp_ns);
}

TEST_F(VanillaInletTest, SamplesWithoutANumberAreNumbered) {
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(comes(0));
  EXPECT_THAT(taken(), ElementsAre(1, 2, 3));
}

TEST_F(VanillaInletTest, WhatCannotBeReadIsDiscardedAndCounted) {
  EXPECT_FALSE(inlet.put({.writer = 1, .sequence = 1}));
  EXPECT_TRUE(comes(2));
  EXPECT_THAT(taken(), ElementsAre(2));
  EXPECT_EQ(inlet.counters().discarded, 1U);
}

TEST_F(VanillaInletTest, ConditionsHoldForEachWriterAndWhatPassesIsNumbered) {
  ask("@ changed(height)");
  const std::uint64_t gate = type.parse_selection("@ changed(height)").value().gate_hash();
  EXPECT_TRUE(comes(1, 1, 10));
  EXPECT_FALSE(comes(2, 1, 10));
  EXPECT_TRUE(comes(1, 2, 10)) << "the first one of that writer";
  EXPECT_TRUE(comes(3, 1, 11));
  std::vector<std::uint32_t> ordinals;
  while (const SampleHandle sample = inlet.take()) {
    EXPECT_EQ(sample->gate, gate_id(gate, 0));
    ordinals.push_back(sample->ordinal);
  }
  EXPECT_THAT(ordinals, ElementsAre(1, 1, 2));
}

TEST_F(VanillaInletTest, SamplesThatWereLostCountAsIfTheyHadPassed) {
  ask("@ height > 0");
  EXPECT_TRUE(comes(1));
  EXPECT_TRUE(comes(5));
  const SampleHandle first = inlet.take(), second = inlet.take();
  EXPECT_EQ(second->ordinal - first->ordinal, 4U);
}

TEST_F(VanillaInletTest, TheMaximumRateHoldsByTheStamps) {
  ask("*", 4000);
  std::vector<std::uint64_t> passed;
  for (std::uint64_t i = 1; i <= 12; ++i) {
    if (comes(i)) passed.push_back(i);
  }
  EXPECT_THAT(passed, ElementsAre(1, 4, 8, 12));
  EXPECT_EQ(inlet.take()->min_period_us, 4000U);
}

TEST_F(VanillaInletTest, AWriterThatHasGoneIsForgottenOnceItsSamplesWereTaken) {
  comes(5, 1);
  const std::vector<EndpointId> nobody;
  inlet.forget_others_than(nobody);
  EXPECT_EQ(inlet.arrivals(1), 1U);
  EXPECT_THAT(taken(), ElementsAre(5));
  inlet.forget_others_than(nobody);
  EXPECT_EQ(inlet.arrivals(1), 0U);
}

TEST_F(VanillaInletTest, NoMoreWaitsOfAllWritersThatHaveGoneThanOfOne) {
  std::vector<EndpointId> present;
  for (EndpointId writer = 1; writer <= 200; ++writer) {
    comes(2 * writer, writer);
    comes(2 * writer + 1, writer);
    inlet.forget_others_than(present);
  }
  EXPECT_THAT(taken(), ElementsAre(399, 400, 401));
  EXPECT_EQ(inlet.counters().discarded, 397U);
  EXPECT_EQ(inlet.counters().lost_unnoticed, 397U);
}

TEST_F(VanillaInletTest, WhatWaitsOfPresentWritersStaysWhateverHasGone) {
  const std::vector<EndpointId> present{1, 2};
  for (const EndpointId writer : present) comes(10 * writer, writer);
  for (EndpointId writer = 3; writer <= 9; ++writer) comes(10 * writer, writer);
  inlet.forget_others_than(present);
  EXPECT_THAT(taken(), ElementsAre(10, 20, 70, 80, 90));
}

TEST_F(VanillaInletTest, SubscribersShareTheMemoryOfASampleUntilTheLastOneHasReadIt) {
  VanillaInlet other(type, 1, 0);
  const SampleHandle sample = whole(1);
  inlet.put({.writer = 1, .sequence = 1, .sample = sample});
  other.put({.writer = 1, .sequence = 1, .sample = sample});
  SampleHandle one = inlet.take(), two = other.take();
  EXPECT_EQ(one->data, two->data);
  EXPECT_FALSE(sample.is_only());
  one.reset();
  two.reset();
  EXPECT_TRUE(sample.is_only());
}

TEST_F(VanillaInletTest, WritersBeyondTheLimitAreRefused) {
  for (EndpointId writer = 1; writer <= VanillaInlet::writers_max; ++writer) comes(1, writer);
  EXPECT_FALSE(comes(1, VanillaInlet::writers_max + 1));
  EXPECT_EQ(inlet.counters().discarded, 1U);
  while (inlet.take()) {
  }
  inlet.forget_others_than(std::vector<EndpointId>{1});
  EXPECT_TRUE(comes(2, VanillaInlet::writers_max + 1)) << "there is room again";
  EXPECT_TRUE(comes(2, 1));
  EXPECT_THAT(taken(), ElementsAre(2, 2));
  EXPECT_EQ(inlet.counters().lost_unnoticed, 0U);
}

TEST_F(VanillaInletTest, TheSameConditionsThatAreAskedForAgainDoNotBeginAnewButOthersDo) {
  ask("@ changed(height)");
  EXPECT_TRUE(comes(1, 1, 10));
  ask("width @ changed(height)");
  EXPECT_FALSE(comes(2, 1, 10)) << "only the fields differ";
  ask("@ changed(height)", 1);
  EXPECT_TRUE(comes(3, 1, 10)) << "the maximum rate differs";
  ask("*");
  EXPECT_TRUE(comes(4, 1, 10));
  std::vector<std::uint64_t> gates;
  while (const SampleHandle sample = inlet.take()) gates.push_back(sample->gate == 0 ? 0 : 1);
  EXPECT_THAT(gates, ElementsAre(1, 1, 0));
}

}  // namespace
}  // namespace sft::core
