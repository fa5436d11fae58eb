// A reader with as_remote gets the same samples in shared memory as it would get on another host.
#include "core/subscribe/remote_copy.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <span>
#include <thread>
#include <vector>

#include "core/subscribe/subscriber_core.h"
#include "tests/support/encoded.h"
#include "tests/support/random_value.h"
#include "tests/unit/core/seam/queue_port.h"

namespace sft::core::test {
namespace {

using namespace detail;

using sensor_msgs::msg::PointCloud2;
using sft::test::Encoded;
using F = PointCloud2::Field;

class RemoteCopyTest : public sft::test::RandomTest {
 protected:
  SampleHandle sample(const PointCloud2& cloud, const FieldMask& mask) {
    const Encoded encoded(type.type(), &cloud, mask);
    SampleHandle buffer = pool->take(layout.bytes(encoded.bytes().size()));
    std::ranges::copy(encoded.bytes(), buffer->data + layout.body_offset);
    std::copy_n(encoded.state().index, type.index_slots(), buffer->index());
    buffer->header().body_bytes = static_cast<std::uint32_t>(encoded.bytes().size());
    buffer->mask = mask;
    buffer->writer = 9;
    buffer->sequence = ++sequence;
    return buffer;
  }
  SampleHandle whole(const PointCloud2& cloud) { return sample(cloud, type.full()); }
  FieldMask closed(const FieldMask& mask) const { return type.closed(mask); }
  ProjectionPlan asked(const FieldMask& mask) const { return {type.type(), closed(mask)}; }
  std::vector<std::byte> body(const SampleBuffer& buffer) const {
    const SampleState state = state_of(buffer, type.index_slots());
    return {state.body, state.body + state.body_bytes};
  }
  PointCloud2 any_cloud() {
    PointCloud2 cloud;
    values.fill(type.type(), &cloud);
    return cloud;
  }

  const TypeSupport& type = type_support<PointCloud2>();
  const SampleLayout layout{type.index_slots()};
  sft::test::RandomValues values{random};
  const std::shared_ptr<BufferPool> pool = BufferPool::make(64 << 20);
  const std::shared_ptr<RemoteCopy> copier = RemoteCopy::make(type, BufferPool::make(64 << 20));
  RemoteCopy& copies = *copier;
  std::uint64_t sequence = 0;
};

TEST_F(RemoteCopyTest, IsTheSampleProjectedByteForByte) {
  for (int round = 0; round < 1000 && !HasFailure(); ++round) {
    const PointCloud2 cloud = any_cloud();
    const FieldMask has = round % 2 == 0 ? type.full() : closed(values.mask(type.leaves()));
    const FieldMask mask = closed(values.mask(type.leaves()));
    const SampleHandle copy = copies.of(sample(cloud, has), asked(mask));
    ASSERT_TRUE(copy);
    const Encoded expected(type.type(), &cloud, mask & has);
    EXPECT_EQ(copy->mask, mask & has);
    EXPECT_EQ(body(*copy), expected.bytes());
    EXPECT_TRUE(std::equal(copy->index(), copy->index() + type.index_slots(), expected.state().index));
    EXPECT_EQ(copy->sequence, sequence);
    EXPECT_EQ(copy->writer, 9U);
  }
}

TEST_F(RemoteCopyTest, IsTheSampleItselfIfThatHasNoMoreThanIsAskedFor) {
  const SampleHandle buffer = sample(any_cloud(), closed(FieldMask(F::width)));
  EXPECT_EQ(&*copies.of(buffer, asked(FieldMask(F::width | F::height))), &*buffer);
}

TEST_F(RemoteCopyTest, IsNotMadeOfBytesThatAreNotOfTheirType) {
  const SampleHandle broken = whole(any_cloud());
  std::fill_n(broken->index(), type.index_slots(), 0xFFFFFF00U);
  EXPECT_FALSE(copies.of(broken, asked(FieldMask(F::width | F::data))));
}

TEST_F(RemoteCopyTest, IsNotMadeWithoutMemory) {
  const std::shared_ptr<RemoteCopy> poor = RemoteCopy::make(type, BufferPool::make(0));
  EXPECT_FALSE(poor->of(whole(any_cloud()), asked(FieldMask(F::width))));
}

class AsRemoteSubscriberTest : public RemoteCopyTest {
 protected:
  AsRemoteSubscriberTest() { subscriber.ports().set_memory(port); }

  const std::unique_ptr<DoorbellPage> bells = DoorbellPage::create();
  const std::shared_ptr<MemoryQueue> port = std::make_shared<MemoryQueue>();
  SubscriberCore subscriber{{.topic = "points",
                             .type = &type,
                             .feeds = {{.id = 1, .selection = type.full()}},
                             .options = {.recording = {.as_remote = true}},
                             .callback = {},
                             .copies = BufferPool::make(64 << 20)},
                            bells->at(1),
                            nullptr};
};

TEST_F(AsRemoteSubscriberTest, GetsWhatItsRequestInForceAsksForWhenItTakes) {
  for (int i = 0; i < 3; ++i) port->samples.push_back(whole(any_cloud()));
  EXPECT_TRUE(subscriber.take().state().mask->is_full());
  subscriber.feed().requests(FieldMask(F::width), 2);
  EXPECT_EQ(*subscriber.take().state().mask, FieldMask(F::width));
  subscriber.feed().requests(FieldMask(F::height), 3);
  EXPECT_EQ(*subscriber.take().state().mask, FieldMask(F::height));
}

TEST_F(AsRemoteSubscriberTest, CountsAsLostWhatItWouldNotHaveGotThere) {
  subscriber.feed().requests(FieldMask(F::width), 2);
  for (int i = 0; i < 3; ++i) port->samples.push_back(whole(any_cloud()));
  std::fill_n(port->samples[1]->index(), type.index_slots(), 0xFFFFFF00U);
  EXPECT_EQ(subscriber.take().info().sequence, 1U);
  const untyped::Sample behind = subscriber.take();
  EXPECT_EQ(behind.info().sequence, 3U);
  EXPECT_EQ(behind.info().lost_before, 1U);
  EXPECT_EQ(subscriber.feed().status().received, 2U);
  EXPECT_EQ(subscriber.feed().status().lost, 1U);
}

TEST_F(AsRemoteSubscriberTest, CountsThosePassedOverAsReceived) {
  subscriber.feed().requests(FieldMask(F::width), 2);
  for (int i = 0; i < 3; ++i) port->samples.push_back(whole(any_cloud()));
  EXPECT_EQ(subscriber.take_latest().info().sequence, 3U);
  EXPECT_EQ(subscriber.feed().status().received, 3U);
}

TEST_F(AsRemoteSubscriberTest, MayTakeOnSeveralThreadsAtOnce) {
  constexpr std::uint64_t samples = 1000;
  subscriber.feed().requests(closed(FieldMask(F::data)), 2);
  for (std::uint64_t i = 1; i <= samples; ++i) {
    PointCloud2 cloud;
    cloud.data.assign(i, static_cast<std::uint8_t>(i));
    port->samples.push_back(whole(cloud));
  }
  std::atomic<std::uint64_t> wrong{0};
  const auto take_all = [&] {
    while (const untyped::Sample sample = subscriber.take()) {
      PointCloud2 cloud;
      cloud.data.assign(sample.info().sequence, static_cast<std::uint8_t>(sample.info().sequence));
      const Encoded expected(type.type(), &cloud, closed(FieldMask(F::data)));
      const SampleState& state = sample.state();
      const std::span body(state.body, state.body_bytes);
      wrong += std::ranges::equal(body, expected.bytes()) ? 0 : 1;
    }
  };
  std::thread other(take_all);
  take_all();
  other.join();
  EXPECT_EQ(wrong, 0U);
  EXPECT_EQ(subscriber.feed().status().received, samples);
}

/// A subscriber on another host than its publishers. It gets the samples that they send to that host.
class PartSubscriberTest : public RemoteCopyTest {
 protected:
  PartSubscriberTest() { subscriber.ports().set_network(port); }

  Selection selection(const char* text) const { return type.closed(type.parse_selection(text).value()); }
  void arrives(const char* text) {
    const Selection sent = selection(text);
    detail::Projection projection;
    const SampleHandle all = whole(cloud);
    ASSERT_TRUE(projection.project(state_of(*all, type.index_slots()), ProjectionPlan(type, sent)));
    SampleHandle buffer = pool->take(layout.bytes(projection.bytes()));
    std::byte* to = buffer->data + layout.body_offset;
    for (const Segment& segment : projection.segments()) {
      std::copy_n(segment.data, segment.bytes, to);
      to += segment.bytes;
    }
    buffer->header().body_bytes = static_cast<std::uint32_t>(projection.bytes());
    buffer->mask = sent.mask();
    buffer->parts = sent.parts_hash();
    buffer->writer = 9;
    buffer->sequence = sequence;
    ASSERT_EQ(build_index(state_of(*buffer, type.index_slots()), type.type(),
                          {buffer->index(), type.index_slots()}),
              WalkStatus::ok);
    port->samples.push_back(std::move(buffer));
  }
  void arrives_merged(const char* text) {
    arrives(text);
    port->samples.back()->merged = true;
  }
  /// Expects the next sample to have the given selection of the cloud.
  void expect_next(const char* text) {
    const untyped::Sample sample = subscriber.take();
    ASSERT_TRUE(sample);
    ASSERT_NE(sample.selection(), nullptr);
    EXPECT_EQ(*sample.selection(), selection(text)) << type.format_selection(*sample.selection());
    detail::Projection projection;
    const SampleHandle all = whole(cloud);
    --sequence;
    ASSERT_TRUE(
        projection.project(state_of(*all, type.index_slots()), ProjectionPlan(type, *sample.selection())));
    std::vector<std::byte> expected;
    for (const Segment& segment : projection.segments())
      expected.insert(expected.end(), segment.data, segment.data + segment.bytes);
    const SampleState& state = sample.whole_state();
    EXPECT_EQ(*state.mask, selection(text).mask());
    EXPECT_EQ(std::vector(state.body, state.body + state.body_bytes), expected) << text;
  }

  static PointCloud2 points() {
    PointCloud2 all;
    all.fields = {{"x", 0, 7, 1}, {"y", 4, 7, 1}, {"z", 8, 7, 1}, {"ring", 12, 4, 1}};
    all.height = 2;
    all.width = 50;
    all.point_step = 16;
    all.row_step = 800;
    for (int i = 0; i < 1600; ++i) all.data.push_back(static_cast<std::uint8_t>(7 * i));
    return all;
  }

  const PointCloud2 cloud = points();
  const std::unique_ptr<DoorbellPage> bells = DoorbellPage::create();
  const std::shared_ptr<NetworkQueue> port = std::make_shared<NetworkQueue>();
  SubscriberCore subscriber{{.topic = "points",
                             .type = &type,
                             .feeds = {{.id = 1, .selection = selection("*")}},
                             .options = {},
                             .callback = {},
                             .copies = BufferPool::make(64 << 20)},
                            bells->at(1),
                            nullptr};
};

TEST_F(PartSubscriberTest, TakesItsPartOutOfAMergedSample) {
  subscriber.feed().requests(selection("data{x,y,z}"), 2);
  arrives_merged("*");
  arrives("data{x,y,z}");
  expect_next("data{x,y,z}");
  expect_next("data{x,y,z}");
  EXPECT_EQ(subscriber.feed().status().received, 2U);
}

/// When a request has just changed, samples of the former request are still under way.
TEST_F(PartSubscriberTest, GetsWholeSamplesOfItsFormerRequestAsTheyAre) {
  arrives("*");
  arrives("*");
  subscriber.feed().requests(selection("data{x,y,z}"), 2);
  expect_next("*");
  expect_next("*");
  arrives("data{x,y,z}");
  subscriber.feed().requests(selection("*"), 3);
  expect_next("data{x,y,z}");
  EXPECT_EQ(subscriber.feed().status().received, 3U);
  EXPECT_EQ(subscriber.feed().status().lost, 0U);
}

/// A merged sample may have the mask of a former request although it is for the present one.
TEST_F(PartSubscriberTest, PrefersThePresentRequestForAMergedSample) {
  const char* const same_fields = "data, fields, height, width, point_step, row_step, is_bigendian";
  subscriber.feed().requests(selection(same_fields), 2);
  subscriber.feed().requests(selection("data{x}"), 3);
  ASSERT_EQ(selection(same_fields).mask(), selection("data{x}").mask());
  arrives_merged(same_fields);
  expect_next("data{x}");
}

TEST_F(PartSubscriberTest, TakesAFormerPartOutOfAMergedSampleThatLacksWhatItAsksForNow) {
  subscriber.feed().requests(selection("data{x}"), 2);
  subscriber.feed().requests(selection("data{y}"), 3);
  subscriber.feed().requests(selection("header"), 4);
  arrives_merged("data, fields, height, width, point_step, row_step, is_bigendian");
  expect_next("data{y}");
  EXPECT_EQ(subscriber.feed().status().received, 1U);
}

TEST_F(PartSubscriberTest, NamesNoConditionsThatAMergedSampleWasNotSentUnder) {
  subscriber.feed().requests(selection("data{x}"), 2);
  subscriber.feed().requests(selection("data{x} @ height > 100"), 3);
  arrives_merged("*");
  expect_next("data{x}");
}

}  // namespace
}  // namespace sft::core::test
