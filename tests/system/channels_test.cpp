// Channels of point clouds over every transport. The channels are declared at compile time, or recorded when
// the program reads them.
#include <gmock/gmock.h>

#include <cstring>
#include <sensor_msgs/msg/LaserScan.hpp>
#include <tuple>
#include <vector>

#include "tests/system/fixture.h"

namespace sft::test {
namespace {

using sensor_msgs::msg::LaserScan;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// Returns a cloud with four points in two rows, and with gaps between their channels. The values of a point
/// are functions of the number of the cloud.
PointCloud2 numbered(std::uint32_t number) {
  PointCloud2 cloud;
  cloud.header.stamp.sec = static_cast<std::int32_t>(number);
  cloud.height = 2;
  cloud.width = 2;
  cloud.fields = {
      {"x", 0, 7, 1}, {"y", 4, 7, 1}, {"z", 8, 7, 1}, {"intensity", 16, 7, 1}, {"ring", 22, 4, 1}};
  cloud.point_step = 32;
  cloud.row_step = 64;
  cloud.data.resize(128, 0xEE);
  for (std::size_t point = 0; point < 4; ++point) {
    for (const auto& [offset, scale] : {std::pair{0, 1.F}, {4, 10.F}, {8, 100.F}, {16, 1000.F}}) {
      const float value = scale * static_cast<float>(number + point);
      std::memcpy(&cloud.data[32 * point + static_cast<std::size_t>(offset)], &value, sizeof value);
    }
  }
  return cloud;
}

/// Returns the selection in the form in which subscribers request it.
Selection closed(std::string_view text) {
  const TypeSupport& type = type_support<PointCloud2>();
  return type.closed(type.parse_selection(text).value());
}

float number_of(std::int32_t second) { return static_cast<float>(second); }

class ChannelsTest : public PubSubTest {
 protected:
  Node a = open("a");
  Node b = open("b");
  Publisher<PointCloud2> pub =
      a.publisher<PointCloud2>("points", {.reliability = Reliability::reliable}).value();
  std::uint32_t published = 0;
};

/// Tests with a subscriber that records the fields that the program reads.
class RecordedChannelsTest : public ChannelsTest {
 protected:
  using Cloud = Sample<PointCloud2, recorded>;

  /// Publishes and reads until the publisher has applied the selection `text`.
  template <class Read>
  bool until_asked_for(std::string_view text, Read read) {
    const Selection wanted = closed(text);
    return eventually([&] {
      pub.publish(numbered(++published));
      if (!sub.wait(2s)) return false;
      while (const Cloud sample = sub.take()) read(sample);
      const auto readers = pub.status().readers;
      return readers.size() == 1 && readers[0].selection == wanted;
    });
  }
  Cloud next() {
    pub.publish(numbered(++published));
    return sub.wait(hang_timeout) ? sub.take() : Cloud();
  }

  Subscriber<PointCloud2, recorded> sub =
      b.subscriber<PointCloud2, recorded>("points",
                                          {.recording = {.learn_samples = 3, .narrow_after_samples = 10}})
          .value();
};

/// Reads x, y and z, and checks their values.
void read_xyz(const Sample<PointCloud2, recorded>& sample) {
  const auto points = sample->points<float, float, float>("x", "y", "z");
  ASSERT_TRUE(points) << points.error().message;
  ASSERT_EQ(points->size(), 4U);
  const float x = number_of(sample.to_partial()->value.header.stamp.sec);
  if (x == 0) return;  // without a stamp the number of the cloud is unknown
  EXPECT_EQ((*points)[3], std::tuple(x + 3, 10 * (x + 3), 100 * (x + 3)));
}

TEST_P(RecordedChannelsTest, AProgramThatReadsPointsIsSentTheirChannelsOnly) {
  ASSERT_TRUE(until_asked_for("data{x,y,z}", read_xyz));
  const Cloud sample = next();
  read_xyz(sample);
  EXPECT_EQ(sample.cdr().size() < 200, !in_shared_memory());
  EXPECT_EQ(sub.requirements().text, "data{x,y,z}");
  EXPECT_EQ(sub.status().lost, 0U);
}

TEST_P(RecordedChannelsTest, AChannelThatIsReadLaterIsAskedForAtOnceAndThenArrives) {
  ASSERT_TRUE(until_asked_for("data{x}", [](const Cloud& sample) { (void)sample->points<float>("x"); }));
  std::vector<Errc> missed;
  ASSERT_TRUE(until_asked_for("data{x,intensity}", [&](const Cloud& sample) {
    const auto points = sample->points<float, float>("x", "intensity");
    if (points) return;
    missed.push_back(points.error().code);
    EXPECT_EQ(points.error().message, "channel 'intensity' was not sent in this sample");
  }));
  EXPECT_EQ(missed.empty(), in_shared_memory());
  EXPECT_THAT(missed, ::testing::Each(Errc::unavailable));
  const Cloud sample = next();
  const auto points = sample->points<float, float>("x", "intensity");
  ASSERT_TRUE(points);
  const auto x = static_cast<float>(published);
  EXPECT_EQ(points->front(), std::tuple(x, 1000 * x));
}

TEST_P(RecordedChannelsTest, AChannelThatIsNoLongerReadIsGivenUp) {
  ASSERT_TRUE(until_asked_for("data{x,z}",
                              [](const Cloud& sample) { (void)sample->points<float, float>("x", "z"); }));
  EXPECT_TRUE(until_asked_for("data{z}", [](const Cloud& sample) { (void)sample->points<float>("z"); }));
}

TEST_P(RecordedChannelsTest, AChannelThatTheCloudLacksIsAnUnknownOneOnceItIsAskedFor) {
  ASSERT_TRUE(until_asked_for("data{x,far}", [](const Cloud& sample) {
    (void)sample->points<float>("x");
    (void)sample->points<float>("far");
  }));
  const Cloud sample = next();
  EXPECT_EQ(sample->points<float>("far").error().code, Errc::unknown_field);
  EXPECT_TRUE(sample->points<float>("x"));
  EXPECT_THAT(sample.missing_channels(), ElementsAre("far"));
  EXPECT_TRUE(until_asked_for("data{x}", [](const Cloud& other) {
    (void)other->points<float>("x");
    (void)other.missing_channels();
  })) << "who asks what is missing has read no field";
}

TEST_P(RecordedChannelsTest, AProgramThatReadsTheBytesOfThePointsIsSentAllOfThem) {
  ASSERT_TRUE(until_asked_for("data{x}", [](const Cloud& sample) { (void)sample->points<float>("x"); }));
  const Cloud narrow = next();
  EXPECT_EQ(narrow->data().has_value(), in_shared_memory()) << "some channels are not the data";
  EXPECT_EQ(narrow->point_step().has_value(), in_shared_memory());
  const std::string whole = "fields, height, width, is_bigendian, point_step, row_step, data";
  EXPECT_TRUE(until_asked_for("data, point_step", [](const Cloud& sample) {
    (void)sample->data();
    (void)sample->point_step();
  }));
  const Cloud whole_points = next();
  EXPECT_EQ(whole_points->data()->size(), 128U);
  EXPECT_TRUE(until_asked_for(whole, [](const Cloud& sample) {
    (void)sample->points<float>("x");
    if (const auto fields = sample->fields()) {
      for (const auto field : *fields) (void)field.name();
    }
  })) << "who reads `fields` may look for channels that it has not named yet";
}

TEST_P(ChannelsTest, ChannelsOfADynamicViewAreRecordedAsWell) {
  auto dynamic = b.subscriber("points", b.find_type("points", hang_timeout).value(), recorded,
                              {.recording = {.learn_samples = 3}})
                     .value();
  const Selection wanted = closed("data{x,z}");
  EXPECT_TRUE(eventually([&] {
    pub.publish(numbered(++published));
    if (!dynamic.wait(2s)) return false;
    while (const DynamicSample sample = dynamic.take()) {
      const auto points = points_of<float, float>(sample.view(), "x", "z");
      EXPECT_TRUE(points) << points.error().message;
    }
    return std::ranges::any_of(pub.status().readers,
                               [&](const auto& reader) { return reader.selection == wanted; });
  }));
  pub.publish(numbered(++published));
  ASSERT_TRUE(dynamic.wait(hang_timeout));
  const DynamicSample sample = dynamic.take();
  EXPECT_EQ(sample.view()["data"].is_absent(), !in_shared_memory());
  EXPECT_EQ(sample.view()["fields"].is_absent(), !in_shared_memory());
  EXPECT_FALSE(sample.view()["height"].is_absent());
}

TEST_P(ChannelsTest, ChannelsAreDeclaredWhenTheProgramIsCompiled) {
  auto declared = b.subscriber<PointCloud2, F::header.stamp | F::data.channels<"x", "intensity">.every(2)>(
                       "points", {.reliability = Reliability::reliable})
                      .value();
  EXPECT_EQ(declared.requirements().text.substr(0, 12), "header.stamp");
  expect_served(pub, 1);
  pub.publish(numbered(7));
  ASSERT_TRUE(declared.wait(hang_timeout));
  const auto sample = declared.take();
  EXPECT_EQ(sample->header().stamp().sec(), 7);
  EXPECT_EQ(sample->width(), 1U);
  EXPECT_EQ(sample->point_step(), 8U);
  EXPECT_EQ(sample->data().size(), 16U);
  const auto points = sample->points<float, float>("x", "intensity");
  ASSERT_TRUE(points) << points.error().message;
  EXPECT_THAT(std::vector(points->begin(), points->end()),
              ElementsAre(std::tuple(7.F, 7000.F), std::tuple(9.F, 9000.F)));
  EXPECT_EQ(sample->points<float>("y").error().code, Errc::unknown_field);
}

TEST_P(ChannelsTest, AnOptionChangesADeclaredPartAndLeavesOthers) {
  SubscriberOptions options{.reliability = Reliability::reliable};
  options.selection = "@ height > 1";
  auto declared =
      b.subscriber<PointCloud2, F::header.stamp | F::data.channels<"x">>("points", options).value();
  expect_served(pub, 1);
  const auto served = [&](std::string_view text) {
    const Selection wanted = closed(text);
    return eventually([&] {
      return std::ranges::any_of(pub.status().readers,
                                 [&](const auto& reader) { return reader.selection == wanted; });
    });
  };
  EXPECT_TRUE(served("header.stamp, data{x} @ height > 1"));
  ASSERT_TRUE(declared.set_selection("data{y}"));
  EXPECT_TRUE(served("header.stamp, data{y}"));
  ASSERT_TRUE(declared.set_selection("data"));
  EXPECT_TRUE(served("header.stamp, data, fields, height, width, is_bigendian, point_step, row_step"));
  ASSERT_TRUE(declared.set_selection("header.stamp @ every 2nd"));
  EXPECT_TRUE(served("header.stamp, data{x} @ every 2nd"));
}

TEST_P(ChannelsTest, SlicesOfListsAreDeclaredWhenTheProgramIsCompiled) {
  using S = LaserScan::Field;
  auto scans = a.publisher<LaserScan>("scan", {.reliability = Reliability::reliable}).value();
  auto declared = b.subscriber<LaserScan, S::angle_min | S::angle_increment | S::ranges.range(1, 0, 2)>(
                       "scan", {.reliability = Reliability::reliable})
                      .value();
  expect_served(scans, 1);
  LaserScan scan;
  scan.angle_min = 1;
  scan.angle_increment = 0.25F;
  scan.ranges = {10, 11, 12, 13, 14};
  scans.publish(scan);
  ASSERT_TRUE(declared.wait(hang_timeout));
  const auto sample = declared.take();
  EXPECT_THAT(sample->ranges(), ElementsAre(11, 13));
  EXPECT_EQ(sample->angle_min(), 1.25F);
  EXPECT_EQ(sample->angle_increment(), 0.5F);
}

const auto every_way = ::testing::Values(Way::shm, Way::udp, Way::udp_sockets);
INSTANTIATE_TEST_SUITE_P(Ways, ChannelsTest, every_way, way_name);
INSTANTIATE_TEST_SUITE_P(Ways, RecordedChannelsTest, every_way, way_name);

}  // namespace
}  // namespace sft::test
