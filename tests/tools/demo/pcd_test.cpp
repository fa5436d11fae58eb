// Tests with files of the Point Cloud Library.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/tools/demo/clouds.h"
#include "tools/demo/clouds/file_formats.h"

namespace sft::demo {
namespace {

using sensor_msgs::msg::PointField;
using testing::HasSubstr;

struct PcdText {
  std::string version = "VERSION 0.7\n";
  std::string fields = "FIELDS x y intensity\n";
  std::string size = "SIZE 4 8 2\n";
  std::string type = "TYPE F F U\n";
  std::string count = "COUNT 1 1 1\n";
  std::string shape = "WIDTH 2\nHEIGHT 1\n";
  std::string points = "POINTS 2\n";
  std::string data = "DATA ascii\n1.5 -2.25 7\nnan 1e3 65535\n";

  std::string text() const {
    return "# .PCD v0.7\n" + version + fields + size + type + count + shape + "VIEWPOINT 0 0 0 1 0 0 0\n" +
           points + data;
  }
  Result<std::vector<InputCloud>> read() const { return read_pcd(bytes_of(text()), 1); }
  std::string error() const {
    const auto clouds = read();
    return clouds ? "no error" : clouds.error().message;
  }
};

template <class T>
T number_at(const PointCloud2& cloud, std::size_t offset) {
  T value;
  std::memcpy(&value, cloud.data.data() + offset, sizeof value);
  return value;
}

TEST(Pcd, OfTextBecomesNumbers) {
  const auto clouds = PcdText().read();
  ASSERT_TRUE(clouds) << clouds.error().message;
  const PointCloud2 cloud = message_in(clouds->front());
  EXPECT_EQ(cloud.point_step, 14U);
  EXPECT_EQ(cloud.row_step, 28U);
  EXPECT_EQ(cloud.fields[1], point_field("y", 4, PointField::FLOAT64));
  EXPECT_EQ(cloud.fields[2], point_field("intensity", 12, PointField::UINT16));
  EXPECT_EQ(number_at<float>(cloud, 0), 1.5F);
  EXPECT_EQ(number_at<double>(cloud, 4), -2.25);
  EXPECT_EQ(number_at<std::uint16_t>(cloud, 12), 7);
  EXPECT_TRUE(std::isnan(number_at<float>(cloud, 14)));
  EXPECT_EQ(number_at<double>(cloud, 18), 1000.0);
  EXPECT_EQ(number_at<std::uint16_t>(cloud, 26), 65535);
}

TEST(Pcd, OfMemoryIsTakenAsItLies) {
  PcdText pcd;
  pcd.data = "DATA binary\n" + std::string("0123456789abcd\n\0\xff................", 28);
  const auto clouds = pcd.read();
  ASSERT_TRUE(clouds) << clouds.error().message;
  const PointCloud2 cloud = message_in(clouds->front());
  EXPECT_EQ(std::string(cloud.data.begin(), cloud.data.end()), pcd.data.substr(12));
}

TEST(Pcd, WithRowsKeepsThem) {
  PcdText pcd;
  pcd.shape = "WIDTH 1\nHEIGHT 2\n";
  const auto clouds = pcd.read();
  ASSERT_TRUE(clouds) << clouds.error().message;
  EXPECT_EQ(clouds->front().shape, "2 x 1 points");
}

TEST(Pcd, WithHistogramsAndPaddingHasThemInItsLayout) {
  PcdText pcd;
  pcd.fields = "FIELDS x _ histogram\n";
  pcd.size = "SIZE 4 1 4\n";
  pcd.type = "TYPE F U F\n";
  pcd.count = "COUNT 1 4 3\n";
  pcd.data = "DATA binary\n" + std::string(40, 'x');
  const auto clouds = pcd.read();
  ASSERT_TRUE(clouds) << clouds.error().message;
  const PointCloud2 cloud = message_in(clouds->front());
  EXPECT_EQ(cloud.point_step, 20U);
  ASSERT_EQ(cloud.fields.size(), 2U);
  EXPECT_EQ(cloud.fields[1], point_field("histogram", 8, PointField::FLOAT32, 3));
}

TEST(Pcd, MayHaveTheLineEndsOfWindows) {
  PcdText pcd;
  pcd.shape = "WIDTH 2\r\nHEIGHT 1\r\n";
  pcd.data = "DATA ascii\r\n1.5 -2.25 7\r\n1 2 3\r\n";
  EXPECT_EQ(pcd.error(), "no error");
}

TEST(Pcd, CompressedIsRefusedWithTheWayOut) {
  PcdText pcd;
  pcd.data = "DATA binary_compressed\n........";
  EXPECT_THAT(pcd.error(), HasSubstr("pcl_convert_pcd_ascii_binary"));
}

TEST(Pcd, IsRefusedWhereverItWasCut) {
  PcdText pcd;
  pcd.data = "DATA binary\n" + std::string(28, 'x');
  const Bytes file = bytes_of(pcd.text());
  for (std::size_t length = 0; length < file.size(); ++length) {
    EXPECT_FALSE(read_pcd(std::span(file).first(length), 1)) << "cut to " << length << " bytes";
  }
}

TEST(Pcd, SurvivesAnyByteBeingWrong) {
  const std::string text = PcdText().text();
  for (std::size_t at = 0; at < text.size(); ++at) {
    for (const char wrong : {'\0', '\n', ' ', '9', '-', 'x', '\xff'}) {
      std::string damaged = text;
      damaged[at] = wrong;
      if (const auto clouds = read_pcd(bytes_of(damaged), 1)) {
        EXPECT_EQ(clouds->size(), 1U) << "byte " << at;
      }
    }
  }
}

TEST(Pcd, OfTextIsRefusedWithTooFewOrTooManyNumbers) {
  PcdText pcd;
  pcd.data = "DATA ascii\n1.5 -2.25 7\n1 2\n";
  EXPECT_THAT(pcd.error(), HasSubstr("fewer points"));
  pcd.data = "DATA ascii\n1 2 3\n1 2 3\n1\n";
  EXPECT_THAT(pcd.error(), HasSubstr("more points"));
}

TEST(Pcd, OfTextIsRefusedWithWhatIsNoNumberOfItsType) {
  for (const std::string wrong : {"x", "1.5", "-1", "65536", "7x"}) {
    PcdText pcd;
    pcd.data = "DATA ascii\n1.5 -2.25 " + wrong + "\n1 2 3\n";
    EXPECT_THAT(pcd.error(), HasSubstr("\"" + wrong + "\" where a number for field intensity")) << wrong;
  }
}

TEST(Pcd, IsRefusedWithHostileSizes) {
  PcdText pcd;
  pcd.points.clear();
  for (const std::string shape : {"WIDTH 4294967295\nHEIGHT 4294967295\n", "WIDTH 4294967295\nHEIGHT 1\n",
                                  "WIDTH 65536\nHEIGHT 65536\n", "WIDTH 1198373\nHEIGHT 1\n"}) {
    pcd.shape = shape;
    EXPECT_THAT(pcd.error(), HasSubstr("more than a sample may have")) << shape;
  }
  pcd.shape = "WIDTH 18446744073709551615\nHEIGHT 1\n";
  EXPECT_THAT(pcd.error(), HasSubstr("where a number is expected"));
  pcd = PcdText();
  pcd.count = "COUNT 1 1 4000000000\n";
  EXPECT_THAT(pcd.error(), HasSubstr("a field of 4000000000 numbers"));
}

TEST(Pcd, IsRefusedWithAHeaderThatContradictsItself) {
  PcdText pcd;
  pcd.points = "POINTS 3\n";
  EXPECT_THAT(pcd.error(), HasSubstr("POINTS 3"));
  pcd = PcdText();
  pcd.size = "SIZE 4 8\n";
  EXPECT_THAT(pcd.error(), HasSubstr("2 values for 3 fields"));
  pcd = PcdText();
  pcd.type.clear();
  EXPECT_THAT(pcd.error(), HasSubstr("lacks SIZE or TYPE"));
  pcd = PcdText();
  pcd.shape.clear();
  EXPECT_THAT(pcd.error(), HasSubstr("lacks FIELDS, WIDTH or HEIGHT"));
}

TEST(Pcd, IsRefusedWithTypesThatPointCloudsDoNotHave) {
  PcdText pcd;
  pcd.type = "TYPE F I U\n";
  EXPECT_THAT(pcd.error(), HasSubstr("field y is of type I with 8 bytes"));
  pcd = PcdText();
  pcd.type = "TYPE F X U\n";
  EXPECT_THAT(pcd.error(), HasSubstr("unknown type \"X\""));
  pcd = PcdText();
  pcd.size = "SIZE 4 3 2\n";
  EXPECT_THAT(pcd.error(), HasSubstr("numbers of 3 bytes"));
}

TEST(Pcd, ThatIsSomethingElseIsRefused) {
  EXPECT_FALSE(read_pcd(bytes_of("P5\n4 4\n255\n................"), 1));
  EXPECT_FALSE(read_pcd(Bytes(1000), 1));
  EXPECT_FALSE(read_pcd({}, 1));
}

}  // namespace
}  // namespace sft::demo
