// Tests with files of encoded messages (.cdr, .cdrlog) and of KITTI scans (.bin).
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <geometry_msgs/msg/Twist.hpp>
#include <nav_msgs/msg/Odometry.hpp>
#include <sensor_msgs/msg/BatteryState.hpp>
#include <sensor_msgs/msg/Image.hpp>
#include <sensor_msgs/msg/LaserScan.hpp>

#include "tests/tools/demo/clouds.h"
#include "tools/demo/clouds/file_formats.h"

namespace sft::demo {
namespace {

using testing::HasSubstr;

constexpr std::size_t no_limit = 1000;

template <class T>
std::string error_of(const Result<T>& result) {
  return result ? "no error" : result.error().message;
}

TEST(Cdr, IsTakenByteForByte) {
  const Bytes payload = payload_of(small_cloud());
  const auto clouds = read_cdr(payload, no_limit);
  ASSERT_TRUE(clouds) << error_of(clouds);
  ASSERT_EQ(clouds->size(), 1U);
  EXPECT_EQ(clouds->front().payload, payload);
  EXPECT_EQ(clouds->front().shape, "3 points");
}

TEST(Cdr, LosesThePaddingOfOtherImplementations) {
  const Bytes payload = payload_of(small_cloud());
  for (std::size_t padding = 1; padding <= 3; ++padding) {
    Bytes padded = payload;
    padded.resize(payload.size() + padding);
    const auto clouds = read_cdr(padded, no_limit);
    ASSERT_TRUE(clouds) << error_of(clouds);
    EXPECT_EQ(clouds->front().payload, payload);
  }
}

TEST(Cdr, IsRefusedWhereverItWasCut) {
  const Bytes payload = payload_of(small_cloud());
  for (std::size_t length = 0; length < payload.size(); ++length) {
    EXPECT_FALSE(read_cdr(std::span(payload).first(length), no_limit)) << "cut to " << length << " bytes";
  }
}

TEST(Cdr, OfAnotherEncodingIsRefused) {
  Bytes big_endian = payload_of(small_cloud());
  big_endian[1] = std::byte{0};
  EXPECT_THAT(error_of(read_cdr(big_endian, no_limit)), HasSubstr("begins with 00 00"));
}

TEST(Cdr, OfAnotherTypeIsRefused) {
  sensor_msgs::msg::LaserScan scan;
  scan.ranges.resize(361, 2.5F);
  sensor_msgs::msg::BatteryState battery;
  battery.voltage = 12.5F;
  battery.cell_voltage.resize(3, 4.1F);
  nav_msgs::msg::Odometry odometry;
  odometry.child_frame_id = "base_link";
  geometry_msgs::msg::Twist twist;
  twist.linear.x = 1.5;
  sensor_msgs::msg::Image image;
  image.height = 4;
  image.width = 4;
  image.encoding = "mono8";
  image.step = 4;
  image.data.resize(16);
  EXPECT_FALSE(read_cdr(payload_of(scan), no_limit));
  EXPECT_FALSE(read_cdr(payload_of(battery), no_limit));
  EXPECT_FALSE(read_cdr(payload_of(odometry), no_limit));
  EXPECT_FALSE(read_cdr(payload_of(twist), no_limit));
  EXPECT_FALSE(read_cdr(payload_of(image), no_limit));
}

TEST(Cdr, WhoseFiguresContradictEachOtherIsRefused) {
  PointCloud2 cloud = small_cloud();
  cloud.height = 2;
  EXPECT_THAT(error_of(read_cdr(payload_of(cloud), no_limit)), HasSubstr("do not fit"));
  cloud = small_cloud();
  cloud.width = 0xffffffff;
  EXPECT_THAT(error_of(read_cdr(payload_of(cloud), no_limit)), HasSubstr("do not fit"));
}

TEST(Cdr, WithoutPointsIsACloudToo) {
  const auto clouds = read_cdr(payload_of(small_cloud(0)), no_limit);
  ASSERT_TRUE(clouds) << error_of(clouds);
  EXPECT_EQ(clouds->front().shape, "0 points");
}

TEST(Cdr, BeyondTheSizeOfASampleIsRefused) {
  const Bytes payload = payload_of(small_cloud(cloud_bytes_max / 4 + 1));
  EXPECT_THAT(error_of(read_cdr(payload, no_limit)), HasSubstr("16.78 MB at most"));
}

TEST(CdrLog, GivesAllItsRecordsInOrder) {
  Bytes log;
  for (std::uint32_t points = 0; points < 5; ++points)
    append(log, record_of(payload_of(small_cloud(points))));
  const auto clouds = read_cdrlog(log, no_limit);
  ASSERT_TRUE(clouds) << error_of(clouds);
  ASSERT_EQ(clouds->size(), 5U);
  for (std::uint32_t points = 0; points < 5; ++points) {
    EXPECT_EQ((*clouds)[points].payload, payload_of(small_cloud(points)));
  }
}

TEST(CdrLog, IsNotReadFurtherThanNeeded) {
  Bytes log = record_of(payload_of(small_cloud()));
  append(log, bytes_of("no record"));
  const auto clouds = read_cdrlog(log, 1);
  ASSERT_TRUE(clouds) << error_of(clouds);
  EXPECT_EQ(clouds->size(), 1U);
}

TEST(CdrLog, IsRefusedWhereverItWasCut) {
  const Bytes record = record_of(payload_of(small_cloud()));
  Bytes log = record;
  append(log, record);
  for (std::size_t length = 0; length < log.size(); ++length) {
    const auto clouds = read_cdrlog(std::span(log).first(length), no_limit);
    EXPECT_EQ(clouds.has_value(), length == record.size()) << "cut to " << length << " bytes";
  }
}

TEST(CdrLog, SaysWhichRecordIsWrong) {
  Bytes log = record_of(payload_of(small_cloud()));
  sensor_msgs::msg::LaserScan scan;
  scan.angle_max = 3.14F;
  scan.ranges.resize(361, 2.5F);
  append(log, record_of(payload_of(scan)));
  EXPECT_THAT(error_of(read_cdrlog(log, no_limit)), HasSubstr("record 2: not a sensor_msgs/PointCloud2"));
}

TEST(CdrLog, WithAHostileLengthIsRefused) {
  Bytes log;
  append(log, std::uint64_t{0});
  append(log, std::uint32_t{0xffffffff});
  append(log, Bytes(100));
  EXPECT_THAT(error_of(read_cdrlog(log, no_limit)), HasSubstr("in the middle of record 1"));
}

TEST(CdrLog, SurvivesAnyByteBeingWrong) {
  const Bytes log = record_of(payload_of(small_cloud()));
  for (std::size_t at = 0; at < log.size(); ++at) {
    for (const unsigned wrong : {0x00U, 0x01U, 0x7fU, 0x80U, 0xffU}) {
      Bytes damaged = log;
      damaged[at] = std::byte(wrong);
      if (const auto clouds = read_cdrlog(damaged, no_limit)) {
        EXPECT_EQ(clouds->size(), 1U) << "byte " << at;
      }
    }
  }
}

TEST(Kitti, BecomesACloudOfFourFloats) {
  Bytes scan;
  for (const float value : {1.0F, 2.0F, 3.0F, 0.5F, 4.0F, 5.0F, 6.0F, 0.25F}) append(scan, value);
  const auto clouds = read_kitti(scan, no_limit);
  ASSERT_TRUE(clouds) << error_of(clouds);
  const PointCloud2 cloud = message_in(clouds->front());
  EXPECT_EQ(cloud.height, 1U);
  EXPECT_EQ(cloud.width, 2U);
  EXPECT_EQ(cloud.point_step, 16U);
  EXPECT_EQ(cloud.row_step, 32U);
  ASSERT_EQ(cloud.fields.size(), 4U);
  EXPECT_EQ(cloud.fields[3].name, "intensity");
  EXPECT_EQ(cloud.fields[3].offset, 12U);
  EXPECT_EQ(std::memcmp(cloud.data.data(), scan.data(), scan.size()), 0);
}

TEST(Kitti, IsRefusedUnlessItIsWholePoints) {
  const Bytes scan(64);
  for (std::size_t length = 0; length <= scan.size(); ++length) {
    const auto clouds = read_kitti(std::span(scan).first(length), no_limit);
    EXPECT_EQ(clouds.has_value(), length > 0 && length % 16 == 0) << length << " bytes";
  }
}

}  // namespace
}  // namespace sft::demo
