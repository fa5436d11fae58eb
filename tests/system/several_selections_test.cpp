// Subscribers with several selections, over every transport.
#include <gmock/gmock.h>
#include <poll.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstring>
#include <mutex>
#include <nav_msgs/msg/Odometry.hpp>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "tests/support/isolated_host.h"
#include "tests/system/fixture.h"

namespace sft::test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Pair;
using ::testing::SizeIs;
using ::testing::UnorderedElementsAre;

class SeveralSelectionsTest : public PubSubTest {
 protected:
  /// The number of the selection and the height of each sample that arrived.
  using Came = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

  static SubscriberOptions with(std::vector<std::string> further) {
    return {.reliability = Reliability::reliable, .depth = 200, .further_selections = std::move(further)};
  }
  DynamicType type() { return b.find_type("points", hang_timeout).value(); }
  void publish(const std::vector<std::uint32_t>& heights) {
    for (const std::uint32_t height : heights) ASSERT_EQ(pub.publish(cloud(height)), PublishStatus::ok);
  }
  static std::pair<std::uint32_t, std::uint32_t> of(const DynamicSample& sample) {
    return {sample.info().selection, sample.view()["height"].as<std::uint32_t>().value_or(0)};
  }
  /// Takes the next `count` samples, which must arrive.
  static Came next(DynamicSubscriber& sub, std::size_t count) {
    Came came;
    while (came.size() < count && sub.wait(hang_timeout)) {
      while (const DynamicSample sample = sub.take()) came.push_back(of(sample));
    }
    return came;
  }

  Node a = open("a");
  Node b = open("b");
  Publisher<PointCloud2> pub =
      a.publisher<PointCloud2>("points", {.reliability = Reliability::reliable}).value();
};

/// Tests with held samples in shared memory. Over UDP the number of held samples is not limited.
class HeldSelectionsTest : public SeveralSelectionsTest {};

TEST_P(SeveralSelectionsTest, EachSampleSaysByWhichOfThemItCame) {
  auto sub = b.subscriber("points", type(), "height, width",
                          with({"height @ height > 100", "height, point_step @ every 3rd"}))
                 .value();
  expect_served(pub, 3);
  publish({1, 2, 101, 102});
  EXPECT_THAT(next(sub, 8), UnorderedElementsAre(Pair(0, 1), Pair(2, 1), Pair(0, 2), Pair(0, 101),
                                                 Pair(1, 101), Pair(0, 102), Pair(1, 102), Pair(2, 102)));
  EXPECT_FALSE(sub.take());
  EXPECT_EQ(sub.status(0).received, 4U);
  EXPECT_EQ(sub.status(1).received, 2U);
  EXPECT_EQ(sub.status(2).received, 2U);
  for (const std::size_t i : {0, 1, 2}) EXPECT_EQ(sub.status(i).lost, 0U) << i;
}

TEST_P(SeveralSelectionsTest, ASampleHasTheFieldsAndTheSelectionThatItCameBy) {
  auto sub = b.subscriber("points", type(), "height", with({"width @ width > 0"})).value();
  expect_served(pub, 2);
  publish({7});
  std::vector<std::string> seen;
  while (seen.size() < 2 && sub.wait(hang_timeout)) {
    while (const DynamicSample sample = sub.take()) {
      seen.push_back(std::to_string(sample.info().selection) + ": " +
                     sample.type().support().format_mask(sample.mask()));
      ASSERT_NE(sample.selection(), nullptr);
      EXPECT_EQ(sample.selection()->mask(), sample.mask());
    }
  }
  EXPECT_THAT(seen, UnorderedElementsAre("0: height", "1: width"));
}

// The first selection requests the pose of each sample, the second selection the covariance of every third
// sample.
TEST_P(SeveralSelectionsTest, ACompiledSubscriberReadsWhatTheSampleHas) {
  using nav_msgs::msg::Odometry;
  auto odometry = a.publisher<Odometry>("odometry", {.reliability = Reliability::reliable}).value();
  SubscriberOptions options = with({"pose.covariance @ every 3rd"});
  options.selection = "pose.pose.position";
  options.recording.as_remote = true;
  auto sub = b.subscriber<Odometry, selected>("odometry", options).value();
  ASSERT_TRUE(odometry.wait_for_subscribers(2, 15s));
  for (int i = 1; i <= 4; ++i) {
    Odometry message;
    message.pose.pose.position.x = i;
    message.pose.covariance[0] = 10 * i;
    ASSERT_EQ(odometry.publish(message), PublishStatus::ok);
  }
  std::vector<double> positions, covariances;
  while (positions.size() + covariances.size() < 6 && sub.wait(hang_timeout)) {
    while (const auto sample = sub.take()) {
      const auto pose = sample->pose();
      const bool is_second = sample.info().selection == 1;
      EXPECT_EQ(pose.covariance().has_value(), is_second);
      EXPECT_EQ(pose.pose().position().x().has_value(), !is_second);
      if (is_second) {
        covariances.push_back((*pose.covariance())[0]);
      } else {
        positions.push_back(*pose.pose().position().x());
      }
    }
  }
  EXPECT_THAT(positions, ElementsAre(1, 2, 3, 4));
  EXPECT_THAT(covariances, ElementsAre(10, 40));
  EXPECT_EQ(odometry.status().readers.size(), 2U);
}

TEST_P(SeveralSelectionsTest, DeclaredFieldsComeInSeveralParts) {
  SubscriberOptions options = with({"@ width > 4"});
  options.selection = "data[::10]";
  auto sub = b.subscriber<PointCloud2, F::width | F::data>("points", options).value();
  expect_served(pub, 2);
  PointCloud2 row = cloud(1);
  row.width = row.row_step = static_cast<std::uint32_t>(row.data.size());
  row.point_step = 1;
  ASSERT_EQ(pub.publish(row), PublishStatus::ok);
  std::vector<std::size_t> bytes;
  while (bytes.size() < 2 && sub.wait(hang_timeout)) {
    while (const auto sample = sub.take()) bytes.push_back(sample->data().size());
  }
  EXPECT_THAT(bytes, UnorderedElementsAre((row.data.size() + 9) / 10, row.data.size()));
}

TEST_P(SeveralSelectionsTest, OneOfThemChangesWithoutTheOthers) {
  auto sub = b.subscriber("points", type(), "height", with({"height @ height > 100"})).value();
  expect_served(pub, 2);
  publish({101});
  EXPECT_THAT(next(sub, 2), UnorderedElementsAre(Pair(0, 101), Pair(1, 101)));
  ASSERT_TRUE(sub.set_selection("height @ height > 200", 1));
  const TypeSupport& support = pub.type();
  ASSERT_TRUE(eventually([&] {
    return std::ranges::any_of(pub.status().readers, [&](const PublisherStatus::Reader& reader) {
      return support.format_selection(reader.selection).ends_with("height > 200");
    });
  }));
  publish({150, 151, 201});
  EXPECT_THAT(next(sub, 4), UnorderedElementsAre(Pair(0, 150), Pair(0, 151), Pair(0, 201), Pair(1, 201)));
  EXPECT_EQ(support.format_selection(sub.status(0).selection), "height");
  EXPECT_EQ(support.format_selection(sub.status(1).selection), "height @ height > 200");
  EXPECT_THAT(sub.set_selection("height", 2).error().message, HasSubstr("there is no selection 2"));
  EXPECT_THAT(sub.set_max_rate_hz(1, 2).error().message, HasSubstr("there is no selection 2"));
  EXPECT_THAT(sub.status(2).writers, IsEmpty());
}

TEST_P(SeveralSelectionsTest, OneCallbackIsCalledForAll) {
  std::mutex mutex;
  Came came;
  std::atomic<int> within{0};
  const auto call_back = [&](const DynamicSample& sample) {
    EXPECT_EQ(within.fetch_add(1), 0);
    {
      const std::lock_guard lock(mutex);
      came.push_back(of(sample));
    }
    within.fetch_sub(1);
  };
  auto sub = b.subscriber("points", type(), "height", with({"height @ every 10th"}), call_back).value();
  expect_served(pub, 2);
  for (std::uint32_t i = 1; i <= 100; ++i) publish({i});
  EXPECT_TRUE(eventually([&] {
    const std::lock_guard lock(mutex);
    return came.size() == 110;
  }));
  const std::lock_guard lock(mutex);
  EXPECT_EQ(std::ranges::count(came, 1U, [](const auto& c) { return c.first; }), 10);
}

TEST_P(SeveralSelectionsTest, OneFileDescriptorTellsOfAll) {
  SubscriberOptions options = with({"height @ height > 100"});
  options.pollable = true;
  auto sub = b.subscriber("points", type(), "height @ height < 100", options).value();
  expect_served(pub, 2);
  publish({1, 101});
  Came came;
  pollfd readable{.fd = sub.file_descriptor(), .events = POLLIN, .revents = 0};
  while (came.size() < 2 && ::poll(&readable, 1, 5000) == 1) {
    while (const DynamicSample sample = sub.take()) came.push_back(of(sample));
  }
  EXPECT_THAT(came, UnorderedElementsAre(Pair(0, 1), Pair(1, 101)));
  EXPECT_EQ(::poll(&readable, 1, 0), 0);
}

// The first selection lets one sample pass, and then no further sample. So only samples of the second
// selection can wake the thread. Over UDP, the waiting thread itself receives the datagrams.
TEST_P(SeveralSelectionsTest, AThreadThatWaitsIsWokenByTheSecondOneAlone) {
  auto sub = b.subscriber("points", type(), "height @ height == 1", with({"height @ height > 100"})).value();
  expect_served(pub, 2);
  publish({1});
  EXPECT_THAT(next(sub, 1), ElementsAre(Pair(0, 1)));
  std::atomic<std::uint32_t> taken{0};
  std::jthread waits([&] {
    for (std::uint32_t height = 101; height <= 110; ++height) {
      ASSERT_TRUE(sub.wait(10s)) << height;
      EXPECT_EQ(of(sub.take()), std::pair(1U, height));
      taken = height;
    }
  });
  for (std::uint32_t height = 101; height <= 110; ++height) {
    publish({height});
    ASSERT_TRUE(eventually([&] { return taken == height; }));
  }
}

TEST_P(SeveralSelectionsTest, TheSubscriberMayBeDestroyedInItsCallback) {
  const DynamicType type = this->type();
  std::optional<DynamicSubscriber> sub;
  std::atomic<bool> is_open{false}, is_gone{false};
  const auto call_back = [&](const DynamicSample&) {
    while (!is_open) std::this_thread::yield();
    sub.reset();
    is_gone = true;
  };
  sub.emplace(b.subscriber("points", type, "height", with({"width", "point_step"}), call_back).value());
  is_open = true;
  expect_served(pub, 3);
  publish({1, 2, 3});
  EXPECT_TRUE(eventually([&] { return is_gone.load() && pub.status().readers.empty(); }));
}

TEST_P(SeveralSelectionsTest, ADeadlineIsForTheFirstOneOnly) {
  SubscriberOptions options = with({"height @ height > 100"});
  options.deadline = 2s;
  options.on_event = [](const Event& event) { EXPECT_NE(event.kind, Event::Kind::deadline_missed); };
  auto promising =
      a.publisher<PointCloud2>("promised", {.reliability = Reliability::reliable, .deadline = 2s}).value();
  auto sub =
      b.subscriber("promised", b.find_type("promised", hang_timeout).value(), "height", options).value();
  // A longer time than the deadline may pass until shared memory is ready.
  ASSERT_TRUE(eventually([&] {
    promising.publish(cloud(1));
    return served(promising) == 2;
  }));
  ASSERT_EQ(promising.publish(cloud(101)), PublishStatus::ok);
  bool has_come[2] = {};
  while (!has_come[0] || !has_come[1]) {
    const Came came = next(sub, 1);
    ASSERT_FALSE(came.empty());
    for (const auto& [selection, height] : came) has_come[selection] = selection == 1 || height == 101;
  }
  for (std::uint32_t height = 3; height < 33; ++height) {
    ASSERT_EQ(promising.publish(cloud(height)), PublishStatus::ok);
    EXPECT_THAT(next(sub, 1), ElementsAre(Pair(0, height)));
    EXPECT_FALSE(sub.wait(100ms));
  }
  EXPECT_EQ(b.snapshot().subscribers[0].qos.deadline, 2s);
  EXPECT_EQ(b.snapshot().subscribers[1].qos.deadline, 0s);
  for (const std::size_t i : {0, 1}) EXPECT_EQ(sub.status(i).writers.at(0).deadlines_missed, 0U) << i;
}

// A selection without fields requests all fields, in each option by which a compiled program can set a
// selection.
TEST_P(SeveralSelectionsTest, AConditionAloneLeavesAllFieldsOfACompiledSubscriber) {
  SubscriberOptions options = with({"", "@ height > 100", "width"});
  options.selection = "@ height > 0";
  auto sub = b.subscriber<PointCloud2, selected>("points", options).value();
  expect_served(pub, 4);
  ASSERT_EQ(sub.selections(), 4U);
  for (const std::size_t i : {0, 1, 2}) EXPECT_TRUE(sub.status(i).mask.is_full()) << i;
  EXPECT_FALSE(sub.status(3).mask.is_full());
  ASSERT_TRUE(sub.set_selection("@ height > 200", 3));
  EXPECT_TRUE(eventually([&] { return sub.status(3).mask.is_full(); }));
  ASSERT_TRUE(sub.set_selection("height", 3));
  EXPECT_TRUE(eventually([&] { return !sub.status(3).mask.is_full(); }));
  EXPECT_THAT(sub.set_selection("hieght", 3).error().message, HasSubstr("did you mean 'height'"));
}

TEST_P(HeldSelectionsTest, SamplesThatAreHeldOfOneLeaveTheOtherItsOwn) {
  warnings_expected = true;  // for warnings about too many held samples
  SubscriberOptions options = with({"height @ height > 100"});
  options.max_held = 2;
  auto sub = b.subscriber("points", type(), "height @ height < 100", options).value();
  expect_served(pub, 2);
  publish({1, 150, 2, 3});
  std::vector<DynamicSample> held;
  while (held.size() < 3 && sub.wait(hang_timeout)) {
    while (DynamicSample sample = sub.take()) held.push_back(std::move(sample));
  }
  ASSERT_THAT(held, SizeIs(3));
  EXPECT_THAT((Came{of(held[0]), of(held[1]), of(held[2])}),
              UnorderedElementsAre(Pair(0, 1), Pair(1, 150), Pair(0, 2)));
  publish({101});
  EXPECT_THAT(next(sub, 1), ElementsAre(Pair(1, 101)));
  EXPECT_FALSE(sub.take()) << "two samples of the first selection are held";
  held.clear();
  EXPECT_THAT(next(sub, 1), ElementsAre(Pair(0, 3)));
  for (const std::size_t i : {0, 1}) EXPECT_EQ(sub.status(i).lost, 0U) << i;
}

TEST_P(SeveralSelectionsTest, ACompiledSubscriberReadsPointsOfChannelsThatItSelects) {
  auto sub = b.subscriber<PointCloud2, selected>("points", {.selection = "data{x,z}"}).value();
  expect_served(pub, 1);
  PointCloud2 row = cloud(1, 24);
  row.height = 1;
  row.width = 2;
  row.point_step = 12;
  row.row_step = 24;
  row.fields.resize(3);
  for (const std::uint32_t i : {0U, 1U, 2U}) {
    row.fields[i] = {
        .name = std::string(1, static_cast<char>('x' + i)), .offset = 4 * i, .datatype = 7, .count = 1};
  }
  const std::array<float, 6> xyz{1, 2, 3, 4, 5, 6};
  std::memcpy(row.data.data(), xyz.data(), sizeof xyz);
  ASSERT_EQ(pub.publish(row), PublishStatus::ok);
  ASSERT_TRUE(sub.wait(hang_timeout));
  const auto sample = sub.take();
  const auto points = sample->points<float, float>("x", "z");
  ASSERT_TRUE(points) << points.error().message;
  std::vector<float> values;
  for (const auto [x, z] : *points) values.insert(values.end(), {x, z});
  EXPECT_THAT(values, ElementsAre(1, 3, 4, 6));
  EXPECT_FALSE(sample->points<float>("y"));
}

TEST_P(SeveralSelectionsTest, AllAreWithdrawnWithTheSubscriber) {
  {
    auto sub = b.subscriber("points", type(), "height", with({"width", "point_step"})).value();
    expect_served(pub, 3);
    const NodeSnapshot snapshot = b.snapshot();
    ASSERT_THAT(snapshot.subscribers, SizeIs(3));
    EXPECT_EQ(snapshot.subscribers[2].fields, "point_step");
  }
  EXPECT_TRUE(eventually([&] { return pub.status().readers.empty(); }));
  EXPECT_THAT(b.snapshot().subscribers, IsEmpty());
}

TEST_P(SeveralSelectionsTest, EventsSayWhichOfThemTheyAreAbout) {
  std::mutex mutex;
  std::vector<std::uint32_t> matched;
  SubscriberOptions options = with({"width"});
  options.on_event = [&](const Event& event) {
    const std::lock_guard lock(mutex);
    if (event.kind == Event::Kind::matched) matched.push_back(event.selection);
  };
  auto sub = b.subscriber("points", type(), "height", options).value();
  EXPECT_TRUE(eventually([&] {
    const std::lock_guard lock(mutex);
    return matched.size() == 2;
  }));
  const std::lock_guard lock(mutex);
  EXPECT_THAT(matched, UnorderedElementsAre(0, 1));
}

TEST_P(SeveralSelectionsTest, WhatCannotWorkIsAnErrorThatSaysWhy) {
  const DynamicType type = this->type();
  const auto why = [&](std::vector<std::string> further) {
    return b.subscriber("points", type, "height", with(std::move(further))).error().message;
  };
  EXPECT_THAT(why({"width", "no_such_field"}), HasSubstr("no_such_field"));
  EXPECT_THAT(why(std::vector<std::string>(16, "width")), HasSubstr("at most 16 selections, not 17"));
  EXPECT_THAT(b.subscriber("points", type, recorded, with({"width"})).error().message,
              HasSubstr("further_selections is not empty, but the fields are recorded"));
  EXPECT_THAT((b.subscriber<PointCloud2, recorded>("points", with({"width"})).error().message),
              HasSubstr("further_selections is not empty, but the fields are recorded"));
  EXPECT_THAT((b.subscriber<PointCloud2, F::height>("points", with({"width"})).error().message),
              HasSubstr("names fields that the subscriber does not declare: width"));
}

TEST_P(SeveralSelectionsTest, SixteenOfThemAreServed) {
  std::vector<std::string> further;
  for (int i = 1; i < 16; ++i) further.push_back("height @ height > " + std::to_string(i));
  auto sub = b.subscriber("points", type(), "height", with(further)).value();
  expect_served(pub, 16);
  publish({0, 15, 16});
  const Came came = next(sub, 1 + 15 + 16);
  EXPECT_THAT(came, SizeIs(1 + 15 + 16));
  EXPECT_EQ(std::ranges::count(came, std::pair(15U, 15U)), 0);
  EXPECT_EQ(std::ranges::count(came, std::pair(15U, 16U)), 1);
}

INSTANTIATE_TEST_SUITE_P(Ways, HeldSelectionsTest, ::testing::Values(Way::shm), way_name);
INSTANTIATE_TEST_SUITE_P(Ways, SeveralSelectionsTest, ::testing::Values(Way::shm, Way::udp, Way::udp_sockets),
                         way_name);

}  // namespace
}  // namespace sft::test
