// Views: the values that getters return, for full and masked samples, declared and recorded.
#include "sft/detail/view.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <nav_msgs/msg/Odometry.hpp>
#include <ranges>
#include <sensor_msgs/msg/BatteryState.hpp>
#include <sensor_msgs/msg/PointCloud2.hpp>

#include "tests/support/encoded.h"

namespace sft {
namespace {

using namespace detail;

using sensor_msgs::msg::PointCloud2;
using F = PointCloud2::Field;
using test::Encoded;

PointCloud2 cloud() {
  PointCloud2 c;
  c.header.stamp.sec = -4;
  c.header.stamp.nanosec = 5;
  c.header.frame_id = "lidar";
  c.height = 2;
  c.width = 3;
  c.fields.resize(3);
  c.fields[0].name = "x";
  c.fields[1].name = "intensity";
  c.fields[1].offset = 16;
  c.fields[2].count = 7;
  c.data = {1, 2, 3, 4, 5};
  c.is_dense = true;
  return c;
}

TEST(ViewTest, GettersOfAFullSampleReadInPlace) {
  const Encoded encoded(cloud());
  const auto view = view_of<PointCloud2, all<PointCloud2>>(encoded.state());
  EXPECT_EQ(view.header().stamp().sec(), -4);
  EXPECT_EQ(view.header().frame_id(), "lidar");
  EXPECT_EQ(view.width(), 3U);
  EXPECT_TRUE(view.is_dense());
  ASSERT_EQ(view.data().size(), 5U);
  EXPECT_EQ(view.data()[4], 5);
  const auto* first = reinterpret_cast<const std::byte*>(view.data().data());
  EXPECT_GE(first, encoded.state().body);
  EXPECT_LT(first, encoded.state().body + encoded.state().body_bytes);
}

TEST(ViewTest, ASequenceOfStructsIsARangeOfViews) {
  const Encoded encoded(cloud());
  const auto view = view_of<PointCloud2, all<PointCloud2>>(encoded.state());
  ASSERT_EQ(view.fields().size(), 3U);
  std::vector<std::string> names;
  for (const auto field : view.fields()) names.emplace_back(field.name());
  EXPECT_EQ(names, (std::vector<std::string>{"x", "intensity", ""}));
  const auto fields = view.fields();
  const auto found = std::ranges::find_if(fields, [](const auto& f) { return f.count() == 7; });
  EXPECT_EQ(std::ranges::distance(fields.begin(), found), 2);
}

TEST(ViewTest, OfAMaskedSampleTheSelectedFieldsAreThere) {
  const Encoded encoded(cloud(), F::width | F::fields.each.offset | F::data);
  constexpr Req<PointCloud2> requirement = F::width | F::fields.each.offset | F::data;
  const auto view = view_of<PointCloud2, requirement>(encoded.state());
  EXPECT_EQ(view.width(), 3U);
  std::vector<std::uint32_t> offsets;
  for (const auto field : view.fields()) offsets.push_back(field.offset());
  EXPECT_EQ(offsets, (std::vector<std::uint32_t>{0, 16, 0}));
  EXPECT_EQ(view.data().size(), 5U);
}

template <class View>
concept has_height = requires(const View& v) {
  v.height();
};
template <class View>
concept has_stamp = requires(const View& v) {
  v.header().stamp().sec();
};
template <class View>
concept has_frame_id = requires(const View& v) {
  v.header().frame_id();
};

TEST(ViewTest, UnderADeclaredMaskOtherGettersDoNotExist) {
  using Width = ViewOf<PointCloud2, F::width>;
  using Stamp = ViewOf<PointCloud2, F::header.stamp>;
  static_assert(!has_height<Width>);
  static_assert(!has_stamp<Width>);
  static_assert(has_stamp<Stamp>);
  static_assert(!has_frame_id<Stamp>);
  static_assert(has_height<ViewOf<PointCloud2, recorded>>);
}

TEST(ViewTest, RecordedGettersAreOptionalAndNoteWhatWasRead) {
  struct Listener final : AccessLog::Listener {
    void first_read(std::size_t leaf) noexcept override { leaves.push_back(leaf); }
    std::vector<std::size_t> leaves;
  } reported;
  std::vector<AccessWord> words(1);
  AccessLog log(words, &reported);
  const Encoded encoded(cloud(), F::width | F::header.stamp);
  SampleState state = encoded.state();
  state.log = &log;
  const auto view = view_of<PointCloud2, recorded>(state);
  for (int times = 0; times < 2; ++times) {
    EXPECT_EQ(view.width(), 3U);
    EXPECT_EQ(view.header().stamp().nanosec(), 5U);
    EXPECT_EQ(view.height(), std::nullopt);
    EXPECT_EQ(view.fields().has_value(), false);
  }
  EXPECT_EQ(words[0].found.load(), FieldMask(F::width | F::header.stamp.nanosec).word(0));
  EXPECT_EQ(words[0].missed.load(), FieldMask(F::height | F::fields.size).word(0));
  EXPECT_EQ(reported.leaves, (std::vector<std::size_t>{4, 1, 3, 5}));
}

TEST(ViewTest, ANestedStructIsCopiedByAssignment) {
  const PointCloud2 whole = cloud();
  const Encoded encoded(whole);
  const auto view = view_of<PointCloud2, all<PointCloud2>>(encoded.state());
  PointCloud2 out;
  out.header = view.header();
  out.header.stamp = view.header().stamp();
  for (const auto field : view.fields()) out.fields.push_back(field);
  EXPECT_EQ(out.header, whole.header);
  EXPECT_EQ(out.fields, whole.fields);
  EXPECT_EQ(view.fields()[1].to_owned(), whole.fields[1]);
  EXPECT_EQ(view.to_owned(), whole);
  EXPECT_FALSE(encoded.state().is_malformed());
}

template <class View>
concept has_copy_of_header = requires(const View& v) {
  v.header().to_owned();
};
template <class View>
concept converts_header = requires(const View& v, std_msgs::msg::Header& header) {
  header = v.header();
};

TEST(ViewTest, ANestedStructOfAMaskedSampleIsCopiedIfAllOfItWasDeclared) {
  constexpr Req<PointCloud2> requirement = F::header | F::data;
  const Encoded encoded(cloud(), F::header | F::data);
  const auto view = view_of<PointCloud2, requirement>(encoded.state());
  const std_msgs::msg::Header header = view.header();
  EXPECT_EQ(header, cloud().header);
  static_assert(converts_header<ViewOf<PointCloud2, requirement>>);
  static_assert(!has_copy_of_header<ViewOf<PointCloud2, F::header.stamp>>);
  static_assert(!converts_header<ViewOf<PointCloud2, F::header.stamp>>);
  static_assert(has_copy_of_header<ViewOf<PointCloud2, recorded>>);
  static_assert(!converts_header<ViewOf<PointCloud2, recorded>>);
}

TEST(ViewTest, ACopyOfARecordedStructNotesAllItsFieldsAndIsEmptyIfOneIsLacking) {
  std::vector<AccessWord> words(1);
  AccessLog log(words, nullptr);
  const Encoded encoded(cloud(), F::header | F::width);
  SampleState state = encoded.state();
  state.log = &log;
  const auto view = view_of<PointCloud2, recorded>(state);
  EXPECT_EQ(view.header().to_owned().value(), cloud().header);
  EXPECT_EQ(words[0].found.load(), FieldMask(F::header).word(0));
  EXPECT_FALSE(view.to_owned());
  EXPECT_EQ(words[0].missed.load(), FieldMask(~(F::header | F::width)).word(0));
}

TEST(ViewTest, DeepStructsAndTheirArraysAreCopied) {
  nav_msgs::msg::Odometry odometry;
  odometry.child_frame_id = "base";
  odometry.pose.pose.orientation.w = 0.5;
  odometry.pose.covariance[35] = 4;
  odometry.twist.covariance[35] = 9;
  const Encoded encoded(odometry);
  const auto view = view_of<nav_msgs::msg::Odometry, all<nav_msgs::msg::Odometry>>(encoded.state());
  EXPECT_EQ(view.pose().to_owned(), odometry.pose);
  EXPECT_EQ(view.pose().pose().to_owned(), odometry.pose.pose);
  EXPECT_EQ(view.twist().to_owned(), odometry.twist);
}

TEST(ViewTest, ACopyOfImpossibleBytesHasDefaultValuesAndFlagsTheSample) {
  Encoded encoded(cloud());
  for (const std::uint32_t offset :
       {0xFFFF0000U, encoded.state().body_bytes, encoded.state().body_bytes - 1}) {
    std::fill_n(encoded.index(), encoded.slots(), offset);
    const SampleState& state = encoded.state();
    const auto view = view_of<PointCloud2, all<PointCloud2>>(state);
    EXPECT_EQ(view.header().to_owned(), std_msgs::msg::Header{});
    EXPECT_TRUE(state.is_malformed());
  }
}

TEST(ViewTest, ArraysAndAlignedScalarsOfDeepStructsAreFound) {
  nav_msgs::msg::Odometry odometry;
  odometry.child_frame_id = "base";
  odometry.pose.pose.orientation.w = 0.5;
  odometry.twist.covariance[35] = 9;
  const Encoded encoded(odometry);
  const auto view = view_of<nav_msgs::msg::Odometry, all<nav_msgs::msg::Odometry>>(encoded.state());
  EXPECT_EQ(view.pose().pose().orientation().w(), 0.5);
  ASSERT_EQ(view.twist().covariance().size(), 36U);
  EXPECT_EQ(view.twist().covariance()[35], 9);
}

TEST(ViewTest, ImpossibleBytesGiveEmptyValuesAndFlagTheSample) {
  Encoded encoded(cloud());
  std::fill_n(encoded.index(), encoded.slots(), 0xFFFF0000U);  // offsets far outside the body
  const SampleState& state = encoded.state();
  const auto view = view_of<PointCloud2, all<PointCloud2>>(state);
  EXPECT_EQ(view.width(), 0U);
  EXPECT_TRUE(view.data().empty());
  EXPECT_TRUE(view.header().frame_id().empty());
  EXPECT_TRUE(view.fields().empty());
  EXPECT_TRUE(state.malformed);
}

}  // namespace
}  // namespace sft
