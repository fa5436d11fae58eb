// Parts of recorded clouds and scans have the bytes that the recording has at these places. A parser that
// is independent of the runtime checks this, and so does Cyclone DDS. Needs the recordings, which are not
// in the repository (recorded_data.h).
#include <gtest/gtest.h>
#include <sensor_msgs/msg/LaserScan.h>
#include <sensor_msgs/msg/PointCloud2.h>

#include <cstring>
#include <filesystem>
#include <optional>
#include <sensor_msgs/msg/LaserScan.hpp>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <span>
#include <string>
#include <string_view>

#include "tests/support/cut.h"
#include "tests/support/cyclone_cdr.h"
#include "tests/support/recorded_data.h"

namespace sft {
namespace {

using sensor_msgs::msg::LaserScan;
using sensor_msgs::msg::PointCloud2;
using test::Payload;

constexpr std::size_t head_bytes = 4;  ///< the bytes of the encapsulation

/// Reads XCDR1, little-endian, value by value. The test fails if a read reaches beyond the end.
class CdrCursor {
 public:
  explicit CdrCursor(std::span<const std::byte> bytes) : bytes_(bytes) {}

  template <class Number>
  Number number() {
    at_ = (at_ + sizeof(Number) - 1) / sizeof(Number) * sizeof(Number);
    Number value{};
    if (at_ + sizeof value > bytes_.size()) {
      ADD_FAILURE() << "it ends before byte " << at_ + sizeof value;
      return value;
    }
    std::memcpy(&value, bytes_.data() + at_, sizeof value);
    at_ += sizeof value;
    return value;
  }
  std::string text() {
    const std::span<const std::byte> bytes = list(1);
    return bytes.empty() ? "" : std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size() - 1);
  }
  /// Returns the bytes of a sequence whose elements have `element` bytes, at most 4.
  std::span<const std::byte> list(std::size_t element) {
    const std::size_t size = std::size_t{number<std::uint32_t>()} * element;
    if (size > bytes_.size() - at_) {
      ADD_FAILURE() << "a sequence leads outside";
      return {};
    }
    at_ += size;
    return bytes_.subspan(at_ - size, size);
  }
  bool is_at_end() const { return at_ == bytes_.size(); }
  std::size_t left() const { return bytes_.size() - at_; }

 private:
  std::span<const std::byte> bytes_;
  std::size_t at_ = 0;
};

struct ParsedHeader {
  explicit ParsedHeader(CdrCursor& cdr)
      : sec(cdr.number<std::int32_t>()), nanosec(cdr.number<std::uint32_t>()), frame(cdr.text()) {}
  std::int32_t sec;
  std::uint32_t nanosec;
  std::string frame;
};

struct ParsedCloud {
  explicit ParsedCloud(CdrCursor cdr) : header(cdr) {
    height = cdr.number<std::uint32_t>();
    width = cdr.number<std::uint32_t>();
    for (std::uint32_t more = cdr.number<std::uint32_t>(); more > 0 && cdr.left() > 0; --more) {
      const std::string name = cdr.text();
      const std::uint32_t offset = cdr.number<std::uint32_t>();
      const int type = cdr.number<std::uint8_t>();
      fields.push_back(name + " " + std::to_string(offset) + " " + std::to_string(type) + " " +
                       std::to_string(cdr.number<std::uint32_t>()));
    }
    is_bigendian = cdr.number<std::uint8_t>();
    point_step = cdr.number<std::uint32_t>();
    row_step = cdr.number<std::uint32_t>();
    data = cdr.list(1);
    is_dense = cdr.number<std::uint8_t>();
    left = cdr.left();
  }
  /// Returns the first 12 bytes of a point, which are x, y and z in all recorded clouds.
  std::span<const std::byte> coordinates(std::size_t row, std::size_t column) const {
    return data.subspan(row * row_step + column * point_step, 12);
  }

  ParsedHeader header;
  std::uint32_t height, width;
  std::vector<std::string> fields;
  std::uint8_t is_bigendian;
  std::uint32_t point_step, row_step;
  std::span<const std::byte> data;
  std::uint8_t is_dense;
  std::size_t left;
};

struct ParsedScan {
  explicit ParsedScan(CdrCursor cdr) : header(cdr) {
    for (float& number : numbers) number = cdr.number<float>();
    ranges = cdr.list(sizeof(float));
    intensities = cdr.list(sizeof(float));
    left = cdr.left();
  }
  static float at(std::span<const std::byte> list, std::size_t i) {
    float value;
    std::memcpy(&value, list.subspan(i * sizeof value, sizeof value).data(), sizeof value);
    return value;
  }
  std::size_t beams() const { return ranges.size() / sizeof(float); }

  ParsedHeader header;
  float
      numbers[7];  ///< angle_min, angle_max, angle_increment, time_increment, scan_time, range_min, range_max
  std::span<const std::byte> ranges, intensities;
  std::size_t left;
};

bool is_same(std::span<const std::byte> a, std::span<const std::byte> b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size()) == 0;
}

class CutCorpusTest : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(test::recorded_data()))
      GTEST_SKIP() << "there are no recordings in " << test::recorded_data();
  }

  static std::span<const std::byte> body_of(const Payload& payload) {
    return std::span(payload).subspan(head_bytes);
  }

  /// Returns the whole message, with only the parts of fields that the text names.
  template <class T>
  static std::vector<std::byte> taken(const Payload& payload, std::string_view text) {
    const TypeSupport& type = type_support<T>();
    const detail::ProjectionPlan plan(type, type.closed(test::all_with<T>(text)));
    EXPECT_EQ(plan.mask(), type.full());

    const std::vector<std::byte> body(payload.begin() + head_bytes, payload.end());
    std::vector<std::uint32_t> index(type.index_slots());
    const FieldMask full = type.full();
    const detail::SampleState source{.body = body.data(),
                                     .body_bytes = static_cast<std::uint32_t>(body.size()),
                                     .index = index.data(),
                                     .mask = &full};
    EXPECT_EQ(detail::build_index(source, type.type(), index), detail::WalkStatus::ok);
    detail::Projection projection;
    EXPECT_TRUE(projection.project(source, plan));
    return test::gathered(projection);
  }

  static Payload recording(const char* file) {
    return test::read_recording(test::recorded_data() / file).value();
  }
};

constexpr const char* ouster_file = "lidar3d/ouster/pointcloud2_0.cdr";

TEST_F(CutCorpusTest, AnOusterCloudOfThreeChannelsHas12BytesAPoint) {
  const Payload payload = recording(ouster_file);
  const ParsedCloud whole{CdrCursor(body_of(payload))};
  const std::vector<std::byte> bytes = taken<PointCloud2>(payload, "data{x,y,z}");
  const ParsedCloud some{CdrCursor(bytes)};
  EXPECT_EQ(some.left, 0U);
  EXPECT_EQ(some.header.sec, 991);
  EXPECT_EQ(some.header.nanosec, whole.header.nanosec);
  EXPECT_EQ(some.header.frame, "os_lidar");
  EXPECT_EQ(some.height, 128U);
  EXPECT_EQ(some.width, 1024U);
  EXPECT_EQ(some.fields, (std::vector<std::string>{"x 0 7 1", "y 4 7 1", "z 8 7 1"}));
  EXPECT_EQ(some.point_step, 12U);
  EXPECT_EQ(some.row_step, 12U * 1024);
  ASSERT_EQ(some.data.size(), 12U * 1024 * 128);
  EXPECT_EQ(some.is_dense, whole.is_dense);
  EXPECT_EQ(some.is_bigendian, whole.is_bigendian);
  ASSERT_EQ(whole.point_step, 48U);
  for (std::size_t row = 0; row < some.height; ++row) {
    for (std::size_t column = 0; column < some.width; ++column)
      ASSERT_TRUE(is_same(some.coordinates(row, column), whole.coordinates(row, column)))
          << row << ", " << column;
  }
}

TEST_F(CutCorpusTest, AnOusterCloudIsThinnedToEveryFourthPoint) {
  const Payload payload = recording(ouster_file);
  const ParsedCloud whole{CdrCursor(body_of(payload))};
  for (const bool has_all_channels : {false, true}) {
    const std::vector<std::byte> bytes =
        taken<PointCloud2>(payload, has_all_channels ? "data[::4]" : "data{x,y,z}[rows ::1, columns ::4]");
    const ParsedCloud some{CdrCursor(bytes)};
    EXPECT_EQ(some.left, 0U);
    EXPECT_EQ(some.height, 128U);
    EXPECT_EQ(some.width, 256U);
    EXPECT_EQ(some.fields.size(), has_all_channels ? 9U : 3U);
    EXPECT_EQ(some.point_step, has_all_channels ? 48U : 12U);
    EXPECT_EQ(some.row_step, 256 * some.point_step);
    ASSERT_EQ(some.data.size(), std::size_t{some.row_step} * 128);
    for (std::size_t row = 0; row < some.height; ++row) {
      for (std::size_t column = 0; column < some.width; ++column)
        ASSERT_TRUE(is_same(some.coordinates(row, column), whole.coordinates(row, 4 * column)))
            << row << ", " << column;
    }
  }
}

TEST_F(CutCorpusTest, AnOusterCloudIsCutToAWindow) {
  const Payload payload = recording(ouster_file);
  const ParsedCloud whole{CdrCursor(body_of(payload))};
  const std::vector<std::byte> bytes = taken<PointCloud2>(payload, "data[rows 60:200:2, columns 1000:]");
  const ParsedCloud some{CdrCursor(bytes)};
  EXPECT_EQ(some.height, 34U);
  EXPECT_EQ(some.width, 24U);
  EXPECT_EQ(some.fields, whole.fields);
  ASSERT_EQ(some.data.size(), std::size_t{34} * 24 * 48);
  for (std::size_t row = 0; row < some.height; ++row)
    ASSERT_TRUE(is_same(
        some.data.subspan(row * some.row_step, 24 * std::size_t{48}),
        whole.data.subspan((60 + 2 * row) * whole.row_step + 1000 * std::size_t{48}, 24 * std::size_t{48})));
}

TEST_F(CutCorpusTest, AnUnalignedTimeIsTakenFromACloudOfOneRow) {
  const Payload payload = recording("cdr/pointcloud2_dds_message.bin");
  const ParsedCloud whole{CdrCursor(body_of(payload))};
  const std::vector<std::byte> bytes = taken<PointCloud2>(payload, "data{timestamp,ring}[5::1000]");
  const ParsedCloud some{CdrCursor(bytes)};
  EXPECT_EQ(some.fields, (std::vector<std::string>{"ring 0 4 1", "timestamp 2 8 1"}));
  EXPECT_EQ(some.height, 1U);
  EXPECT_EQ(some.width, 64U);
  EXPECT_EQ(some.point_step, 10U);
  ASSERT_EQ(some.data.size(), 640U);
  for (std::size_t i = 0; i < 64; ++i)
    ASSERT_TRUE(is_same(some.data.subspan(10 * i, 10), whole.data.subspan((5 + 1000 * i) * 26 + 16, 10)));
}

TEST_F(CutCorpusTest, SmallCloudsKeepTheirCoordinatesAndSomeHaveNone) {
  int without_points = 0;
  for (const Payload& payload :
       test::read_records(test::recorded_data() /
                          "rosbag2/extracted/neato_obstacle-avoider__projected_stable_scan.cdrlog")) {
    const ParsedCloud whole{CdrCursor(body_of(payload))};
    const std::vector<std::byte> bytes = taken<PointCloud2>(payload, "data{x,y,z}[::4]");
    const ParsedCloud some{CdrCursor(bytes)};
    without_points += whole.width == 0 ? 1 : 0;
    ASSERT_EQ(some.left, 0U);
    ASSERT_EQ(some.width, (whole.width + 3) / 4);
    ASSERT_EQ(some.data.size(), some.width * std::size_t{12});
    for (std::size_t i = 0; i < some.width; ++i)
      ASSERT_TRUE(is_same(some.coordinates(0, i), whole.coordinates(0, 4 * i)));
  }
  EXPECT_EQ(without_points, 8);
}

TEST_F(CutCorpusTest, ScansAreThinnedToEveryFourthBeam) {
  const std::vector<Payload> records =
      test::read_records(test::recorded_data() / "rosbag2/extracted/neato_obstacle-avoider__scan.cdrlog");
  EXPECT_EQ(records.size(), 153U);
  for (const Payload& payload : records) {
    const ParsedScan whole{CdrCursor(body_of(payload))};
    const std::vector<std::byte> bytes = taken<LaserScan>(payload, "ranges[::4], intensities[::4]");
    const ParsedScan some{CdrCursor(bytes)};
    ASSERT_EQ(some.left, 0U);
    ASSERT_EQ(whole.beams(), 361U);
    ASSERT_EQ(some.beams(), 91U);
    ASSERT_EQ(some.intensities.size(), some.ranges.size());
    EXPECT_EQ(some.numbers[0], whole.numbers[0]) << "the first angle";
    EXPECT_NEAR(some.numbers[1], double{whole.numbers[0]} + 360 * double{whole.numbers[2]}, 5e-7);
    EXPECT_EQ(some.numbers[2], 4 * whole.numbers[2]) << "the angle between two beams";
    EXPECT_EQ(some.numbers[3], 4 * whole.numbers[3]) << "the time between two beams";
    for (std::size_t i = 4; i < 7; ++i) EXPECT_EQ(some.numbers[i], whole.numbers[i]);
    EXPECT_EQ(some.header.nanosec, whole.header.nanosec);
    for (std::size_t i = 0; i < some.beams(); ++i) {
      const float before = ParsedScan::at(whole.ranges, 4 * i);
      ASSERT_EQ(std::memcmp(&before, some.ranges.data() + 4 * i, sizeof before), 0);
      ASSERT_EQ(ParsedScan::at(some.intensities, i), 10.0F);
    }
  }
}

TEST_F(CutCorpusTest, ACycloneReaderTakesPartsOfClouds) {
  const Payload payload = recording(ouster_file);
  const ParsedCloud whole{CdrCursor(body_of(payload))};
  test::CycloneReader reader(sensor_msgs_msg_PointCloud2_desc);
  for (const char* text : {"data{x,y,z}", "data{x,y,z}[::4]", "data[rows 3:9, columns ::7]", "data[0:0]"}) {
    const std::vector<std::byte> bytes = taken<PointCloud2>(payload, text);
    const auto* cloud = static_cast<const sensor_msgs_msg_PointCloud2*>(reader.deserialize(bytes));
    ASSERT_NE(cloud, nullptr) << text;
    EXPECT_EQ(std::uint64_t{cloud->height} * cloud->row_step, cloud->data._length) << text;
    EXPECT_STREQ(cloud->header.frame_id, "os_lidar");
    EXPECT_EQ(cloud->is_dense, whole.is_dense != 0);
    ASSERT_GT(cloud->fields._length, 0U) << text;
    EXPECT_STREQ(cloud->fields._buffer[0].name, "x") << text;
  }
}

TEST_F(CutCorpusTest, ACycloneReaderTakesPartsOfScans) {
  test::CycloneReader reader(sensor_msgs_msg_LaserScan_desc);
  for (const Payload& payload : test::read_records(
           test::recorded_data() / "rosbag2/extracted/neato_obstacle-avoider__stable_scan.cdrlog")) {
    const ParsedScan whole{CdrCursor(body_of(payload))};
    const std::vector<std::byte> bytes = taken<LaserScan>(payload, "ranges[1:300:4], intensities[1:300:4]");
    const auto* scan = static_cast<const sensor_msgs_msg_LaserScan*>(reader.deserialize(bytes));
    ASSERT_NE(scan, nullptr);
    ASSERT_EQ(scan->ranges._length, 75U);
    ASSERT_EQ(scan->intensities._length, 75U);
    EXPECT_FLOAT_EQ(scan->angle_increment, 4 * whole.numbers[2]);
    const float last = ParsedScan::at(whole.ranges, 297);
    EXPECT_EQ(std::memcmp(&last, &scan->ranges._buffer[74], sizeof last), 0);
  }
}

}  // namespace
}  // namespace sft
