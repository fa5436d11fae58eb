// Channels of clouds are recorded in the same way as leaves.
#include "core/subscribe/channel_numbers.h"

#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "core/subscribe/recorder.h"
#include "sft/type_support.h"

namespace sft::core {
namespace {

using sensor_msgs::msg::PointCloud2;
using F = PointCloud2::Field;

class ChannelNumbersTest : public ::testing::Test {
 protected:
  static const TypeSupport& type() { return type_support<PointCloud2>(); }
  static std::vector<ChannelNumbers::Cloud> clouds() { return ChannelNumbers::clouds_of(type().type()); }

  /// Records one sample. The given leaves and channels are read from it.
  void sample(std::initializer_list<std::size_t> read, std::initializer_list<std::string_view> channels) {
    RecordedSample* s = recorder->begin();
    for (const std::size_t leaf : read) s->log().touch(leaf, true);
    for (const std::string_view name : channels)
      EXPECT_EQ(s->log().touch_channel(data, name, true), std::optional(true));
    Recorder::end(s);
  }
  std::string required() const { return type().format_selection(recorder->required()); }

  const std::size_t leaves = type().leaves();
  const std::size_t data = *FieldMask(F::data).begin();
  std::atomic<int> changes{0};
  std::shared_ptr<Recorder> recorder = Recorder::make(
      leaves, {.learn_samples = 2, .narrow_after_samples = 4}, [this] { ++changes; }, clouds());
};

TEST_F(ChannelNumbersTest, ACloudHasItsDataAndTheFieldsThatDescribeIt) {
  const auto found = clouds();
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].data, data);
  EXPECT_EQ(found[0].changed, FieldMask(F::fields | F::point_step | F::row_step | F::data));
  EXPECT_EQ(found[0].fields, found[0].changed | FieldMask(F::height | F::width | F::is_bigendian));
}

TEST_F(ChannelNumbersTest, ChannelsAreLearntLikeLeaves) {
  sample({3}, {"x"});
  EXPECT_TRUE(recorder->required().is_mask());
  EXPECT_TRUE(recorder->required().mask().is_full());
  sample({}, {"z"});
  EXPECT_EQ(required(), "height, data{x,z}");
}

TEST_F(ChannelNumbersTest, AChannelThatIsReadLaterWidensAtOnce) {
  for (int i = 0; i < 2; ++i) sample({}, {"x"});
  changes = 0;
  RecordedSample* s = recorder->begin();
  EXPECT_EQ(s->log().touch_channel(data, "ring", false), std::optional(false));
  EXPECT_EQ(required(), "data{ring,x}");
  EXPECT_EQ(changes, 1);
  Recorder::end(s);
  EXPECT_EQ(changes, 1);
}

TEST_F(ChannelNumbersTest, AChannelThatIsNotReadForLongIsGivenUp) {
  sample({}, {"x", "y"});
  for (int i = 0; i < 3; ++i) sample({}, {"x"});
  EXPECT_EQ(required(), "data{x,y}");
  sample({}, {"x"});
  EXPECT_EQ(required(), "data{x}");
  for (int i = 0; i < 4; ++i) sample({}, {});
  EXPECT_TRUE(recorder->required().mask().empty());
}

TEST_F(ChannelNumbersTest, WhoReadsTheDataOrItsDescriptionNeedsWholePoints) {
  const auto known = clouds();
  for (const std::size_t leaf : known[0].changed) {
    recorder = Recorder::make(
        leaves, {.learn_samples = 1}, [] {}, known);
    sample({leaf}, {"x"});
    const Selection asked = recorder->required();
    EXPECT_TRUE(asked.is_mask()) << leaf;
    EXPECT_TRUE(asked.mask().contains(data)) << leaf;
    EXPECT_TRUE(asked.mask().contains(leaf)) << leaf;
  }
}

TEST_F(ChannelNumbersTest, ASampleWithSomeChannelsLacksTheOthersAndTheWholeData) {
  const Selection asked = type().closed(type().parse_selection("data{x}, height").value());
  const auto sent = std::make_shared<detail::ChannelsSent>(recorder->sent_for(asked).value());
  RecordedSample* s = recorder->begin();
  s->set_channels_sent(sent);
  EXPECT_EQ(s->log().touch_channel(data, "x", true), std::optional(true));
  EXPECT_EQ(s->log().touch_channel(data, "y", true), std::optional(false));
  EXPECT_EQ(s->log().touch_channel(data, "x", false), std::optional(false)) << "without the data";
  EXPECT_FALSE(s->log().is_as_published(data, 1));
  EXPECT_TRUE(s->log().is_as_published(*FieldMask(F::height).begin(), 1));
  Recorder::end(s);
  EXPECT_EQ(sent.use_count(), 1) << "a released sample holds nothing";
  s = recorder->begin();
  EXPECT_TRUE(s->log().is_as_published(data, 1)) << "the next sample has everything again";
  Recorder::end(s);
  EXPECT_FALSE(recorder->sent_for(type().parse_selection("data, height").value()));
}

TEST_F(ChannelNumbersTest, ReadsOfChannelsCountForAllFieldsThatTheyNeedOncePerSample) {
  for (int i = 0; i < 3; ++i) sample({}, {"x", "y"});
  const Recorder::Use use = recorder->use();
  EXPECT_EQ(use.leaves[data].samples, 3U);
  EXPECT_EQ(use.leaves[*FieldMask(F::width).begin()].samples, 3U);
  EXPECT_EQ(use.leaves[*FieldMask(F::is_dense).begin()].samples, 0U);
  EXPECT_EQ(type().format_selection(use.read), "data{x,y}");
}

TEST_F(ChannelNumbersTest, AChannelKeepsItsNumberAndThereAreOnlySoMany) {
  ChannelNumbers channels(leaves, clouds());
  std::set<std::size_t> numbers;
  for (std::size_t i = 0; i < ChannelNumbers::most; ++i)
    numbers.insert(channels.number_of(data, "c" + std::to_string(i)).value());
  EXPECT_EQ(numbers.size(), ChannelNumbers::most);
  EXPECT_EQ(*numbers.begin(), leaves);
  EXPECT_EQ(*numbers.rbegin() + 1, channels.numbers());
  EXPECT_FALSE(channels.number_of(data, "one more"));
  EXPECT_EQ(channels.number_of(data, "c7"), std::optional(leaves + 7));
}

TEST_F(ChannelNumbersTest, WhatARequestCannotNameHasNoNumber) {
  ChannelNumbers channels(leaves, clouds());
  for (const std::string& name :
       {std::string(), std::string("a,b"), std::string(" a"), std::string("a\nb"), std::string(300, 'a')})
    EXPECT_FALSE(channels.number_of(data, name)) << name;
  EXPECT_FALSE(channels.number_of(data - 1, "x"));
  ChannelNumbers none(leaves, {});
  EXPECT_EQ(none.numbers(), leaves);
  EXPECT_FALSE(none.number_of(data, "x"));
}

TEST_F(ChannelNumbersTest, NamesThatAreTooLongTogetherForARequestMeanWholePoints) {
  ChannelNumbers channels(leaves, clouds());
  FieldMask numbers(channels.numbers());
  for (std::size_t i = 0; i < ChannelNumbers::most; ++i)
    numbers.insert(channels.number_of(data, std::string(60, 'a') + std::to_string(i)).value());
  const Selection asked = channels.selection(numbers);
  EXPECT_TRUE(asked.is_mask());
  EXPECT_EQ(asked.mask(), clouds()[0].fields);
}

TEST_F(ChannelNumbersTest, ThreadsThatMeetAChannelAtTheSameTimeGetOneNumber) {
  ChannelNumbers channels(leaves, clouds());
  constexpr std::size_t names = 32;
  std::vector<std::vector<std::size_t>> found(4);
  std::vector<std::thread> threads;
  for (auto& numbers : found) {
    threads.emplace_back([&] {
      for (std::size_t i = 0; i < names; ++i)
        numbers.push_back(channels.number_of(data, "c" + std::to_string(i)).value());
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (const auto& numbers : found) EXPECT_EQ(numbers, found[0]);
  EXPECT_EQ(std::set(found[0].begin(), found[0].end()).size(), names);
}

}  // namespace
}  // namespace sft::core
