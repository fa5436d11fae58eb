// Tests of what --input may name, with files of encoded messages.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cstddef>
#include <string_view>
#include <vector>

#include <geometry_msgs/msg/Twist.hpp>
#include <nav_msgs/msg/Odometry.hpp>
#include <sensor_msgs/msg/BatteryState.hpp>
#include <sensor_msgs/msg/Image.hpp>
#include <sensor_msgs/msg/LaserScan.hpp>
#include <sensor_msgs/msg/PointCloud2.hpp>

#include "sft/detail/sample_format.h"
#include "tests/support/encoded.h"
#include "tests/support/temporary_directory.h"
#include "tools/demo/clouds/point_cloud_files.h"

namespace sft::demo {
namespace {

using sensor_msgs::msg::PointCloud2;
using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;
using Bytes = std::vector<std::byte>;

/// A cloud of one row of `points` points of 4 bytes.
PointCloud2 small_cloud(std::uint32_t points = 3) {
  PointCloud2 cloud;
  cloud.header.frame_id = "lidar";
  cloud.height = 1;
  cloud.width = points;
  cloud.fields = {{"x", 0, sensor_msgs::msg::PointField::FLOAT32, 1}};
  cloud.point_step = 4;
  cloud.row_step = 4 * points;
  cloud.data.resize(cloud.row_step, 0x2a);
  return cloud;
}

/// The encapsulation and body of a message, as DDS would send them.
template <class T>
Bytes payload_of(const T& message) {
  const auto encapsulation = std::as_bytes(std::span(sft::detail::encapsulation_cdr_le));
  Bytes payload(encapsulation.begin(), encapsulation.end());
  const Bytes body = test::Encoded(message).bytes();
  payload.insert(payload.end(), body.begin(), body.end());
  return payload;
}

class InputTest : public testing::Test {
 protected:
  std::filesystem::path write(const std::string& name, const Bytes& bytes) {
    return directory_.write(name, std::span<const std::byte>(bytes));
  }
  static std::string error_on(const std::filesystem::path& path) {
    const auto clouds = read_point_clouds(path, 100);
    return clouds ? "no error" : clouds.error().message;
  }
  std::string error_of(const Bytes& payload) { return error_on(write("a.cdr", payload)); }

  test::TemporaryDirectory directory_;
};

TEST_F(InputTest, MayBeAFileWhichIsTakenByteForByte) {
  const auto clouds = read_point_clouds(write("a.cdr", payload_of(small_cloud(5))), 100);
  ASSERT_TRUE(clouds) << clouds.error().message;
  EXPECT_EQ(clouds->shape, "1 x 5 points");
  EXPECT_EQ(clouds->name, (directory_.path() / "a.cdr").native());
  EXPECT_THAT(clouds->payloads, testing::ElementsAre(payload_of(small_cloud(5))));
}

TEST_F(InputTest, MayBeADirectoryWhichIsReadInTheOrderOfTheNames) {
  write("2.cdr", payload_of(small_cloud(2)));
  write("1.cdr", payload_of(small_cloud(1)));
  write("notes.txt", Bytes(5));
  const auto clouds = read_point_clouds(directory_.path(), 100);
  ASSERT_TRUE(clouds) << clouds.error().message;
  EXPECT_EQ(clouds->shape, "several sizes");
  EXPECT_THAT(clouds->payloads, testing::ElementsAre(payload_of(small_cloud(1)), payload_of(small_cloud(2))));
}

TEST_F(InputTest, IsNotReadFurtherThanNeeded) {
  write("1.cdr", payload_of(small_cloud(1)));
  write("2.cdr", Bytes(5));
  const auto clouds = read_point_clouds(directory_.path(), 1);
  ASSERT_TRUE(clouds) << clouds.error().message;
  EXPECT_EQ(clouds->payloads.size(), 1U);
}

TEST_F(InputTest, MayHaveThePaddingOfOtherImplementations) {
  Bytes payload = payload_of(small_cloud());
  payload.resize(payload.size() + 3);
  EXPECT_EQ(error_of(payload), "no error");
}

TEST_F(InputTest, WithoutPointsIsACloudToo) { EXPECT_EQ(error_of(payload_of(small_cloud(0))), "no error"); }

TEST_F(InputTest, IsRefusedWhereverItWasCut) {
  const Bytes payload = payload_of(small_cloud());
  for (std::size_t length = 0; length < payload.size(); ++length) {
    const Bytes cut(payload.begin(), payload.begin() + static_cast<std::ptrdiff_t>(length));
    EXPECT_THAT(error_of(cut), HasSubstr("a.cdr: ")) << "cut to " << length << " bytes";
  }
}

TEST_F(InputTest, SurvivesAnyByteBeingWrong) {
  const Bytes payload = payload_of(small_cloud());
  for (std::size_t at = 0; at < payload.size(); ++at) {
    for (const unsigned wrong : {0x00U, 0x01U, 0x7fU, 0x80U, 0xffU}) {
      Bytes damaged = payload;
      damaged[at] = std::byte(wrong);
      EXPECT_FALSE(error_of(damaged).empty()) << "byte " << at;
    }
  }
}

TEST_F(InputTest, OfAnotherEncodingIsRefused) {
  Bytes big_endian = payload_of(small_cloud());
  big_endian[1] = std::byte{0};
  EXPECT_THAT(error_of(big_endian), HasSubstr("little-endian"));
}

TEST_F(InputTest, OfAnotherTypeIsRefused) {
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
  for (const Bytes& payload :
       {payload_of(scan), payload_of(battery), payload_of(odometry), payload_of(twist), payload_of(image)}) {
    EXPECT_THAT(error_of(payload), HasSubstr("not a sensor_msgs/PointCloud2"));
  }
}

TEST_F(InputTest, WhoseFiguresContradictEachOtherIsRefused) {
  PointCloud2 cloud = small_cloud();
  cloud.height = 2;
  EXPECT_THAT(error_of(payload_of(cloud)), HasSubstr("not a sensor_msgs/PointCloud2"));
  cloud = small_cloud();
  cloud.width = 0xffffffff;
  EXPECT_THAT(error_of(payload_of(cloud)), HasSubstr("not a sensor_msgs/PointCloud2"));
}

TEST_F(InputTest, BeyondTheSizeOfASampleIsRefused) {
  EXPECT_THAT(error_of(Bytes(16 * 1024 * 1024 + 1)), HasSubstr("larger than 16 MiB"));
}

TEST_F(InputTest, ThatIsDamagedIsNamed) {
  write("1.cdr", payload_of(small_cloud(1)));
  const auto damaged = write("2.cdr", Bytes(5));
  EXPECT_THAT(error_on(directory_.path()), StartsWith(damaged.native() + ": "));
}

TEST_F(InputTest, OfUnknownFormatIsNamedWithTheKnownOne) {
  const auto unknown = write("cloud.las", Bytes(16));
  EXPECT_THAT(error_on(unknown), AllOf(StartsWith(unknown.native()), HasSubstr(".cdr")));
}

TEST_F(InputTest, ThatIsNotThereIsNamed) {
  EXPECT_THAT(error_on(directory_.path() / "none.cdr"), HasSubstr("none.cdr: no such file or directory"));
}

TEST_F(InputTest, ThatIsAnEmptyDirectoryIsRefused) {
  write("readme.txt", Bytes(5));
  EXPECT_THAT(error_on(directory_.path()), HasSubstr("no .cdr file"));
}

TEST_F(InputTest, ThatIsNeitherFileNorDirectoryIsRefused) {
  const auto pipe = directory_.path() / "pipe.cdr";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  const auto link = directory_.path() / "null.cdr";
  std::filesystem::create_symlink("/dev/null", link);
  EXPECT_THAT(error_on(link), HasSubstr("neither a file"));
  EXPECT_THAT(error_on(pipe), HasSubstr("neither a file"));
}

}  // namespace
}  // namespace sft::demo
