// Recorded payloads of other programs decode to known values, encode to the same bytes again, and obey the
// projection law. Needs the recordings, which are not in the repository (recorded_data.h).
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <nav_msgs/msg/Odometry.hpp>
#include <ostream>
#include <ranges>
#include <sensor_msgs/msg/BatteryState.hpp>
#include <sensor_msgs/msg/LaserScan.hpp>
#include <sensor_msgs/msg/PointCloud2.hpp>

#include "sft/detail/decode.h"
#include "sft/detail/project.h"
#include "sft/detail/sample_format.h"
#include "sft/detail/view.h"
#include "tests/support/encoded.h"
#include "tests/support/random_value.h"
#include "tests/support/recorded_data.h"

namespace sft {
namespace {

using namespace detail;

using nav_msgs::msg::Odometry;
using sensor_msgs::msg::BatteryState;
using sensor_msgs::msg::LaserScan;
using sensor_msgs::msg::PointCloud2;
using test::Encoded;
using test::Payload;

template <class V>
V value_at(std::span<const std::uint8_t> bytes, std::size_t offset) {
  V value;
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

/// A recorded payload as a receiver holds it: the body is in aligned memory of exactly its size, and was
/// walked.
template <class T>
class Received {
 public:
  explicit Received(const Payload& payload)
      : body_(payload.begin() + std::min(encapsulation_bytes, payload.size()), payload.end()) {
    EXPECT_GE(payload.size(), encapsulation_bytes);
    EXPECT_EQ(std::memcmp(payload.data(), encapsulation_cdr_le.data(), encapsulation_bytes), 0);
    state_ = {body_.data(), static_cast<std::uint32_t>(body_.size()), index_.data(), &full_};
    status_ = build_index(state_, TypeTable<T>::type, index_, &end_);
  }
  Received(const Received&) = delete;
  Received& operator=(const Received&) = delete;

  WalkStatus status() const { return status_; }
  const SampleState& state() const { return state_; }
  auto view() const { return view_of<T, R>(state_); }

  T decoded() const {
    T value;
    EXPECT_EQ(decode(state_, TypeTable<T>::type, &value), WalkStatus::ok);
    return value;
  }

  std::vector<std::byte> body() const { return {body_.begin(), body_.begin() + end_}; }
  std::vector<std::byte> trailing() const { return {body_.begin() + end_, body_.end()}; }

 private:
  static constexpr Req<T> R = all<T>;
  std::vector<std::byte> body_;  // aligned, because heap memory is aligned to 16 bytes
  FieldMask full_ = FieldMask::full(leaf_count_of<T>);
  std::vector<std::uint32_t> index_ = std::vector<std::uint32_t>(slot_count(TypeTable<T>::type));
  SampleState state_{};
  std::uint32_t end_ = 0;
  WalkStatus status_{};
};

class CorpusTest : public test::RandomTest {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(test::recorded_data())) {
      GTEST_SKIP() << "there are no recordings in " << test::recorded_data();
    }
  }

  /// Checks the laws that hold for each payload of a message of type T.
  template <class T>
  void check(const Payload& payload, int masks = 5) {
    const Received<T> received(payload);
    ASSERT_EQ(received.status(), WalkStatus::ok) << to_string(received.status());
    EXPECT_TRUE(std::ranges::all_of(received.trailing(), [](std::byte b) { return b == std::byte{0}; }));

    const T message = received.decoded();
    EXPECT_TRUE(Encoded(message).bytes() == received.body()) << "encoding what was decoded gives other bytes";

    const TypeSupport support(TypeTable<T>::type);
    Projection projection;
    for (int i = 0; i < masks; ++i) {
      const FieldMask mask = support.closed(values.mask(support.leaves()));
      ASSERT_TRUE(projection.project(received.state(), support.type(), mask));
      std::vector<std::byte> projected;
      for (const Segment& s : projection.segments())
        projected.insert(projected.end(), s.data, s.data + s.bytes);
      EXPECT_TRUE(projected == Encoded(support.type(), &message, mask).bytes()) << support.format_mask(mask);
    }
  }

  template <class T>
  std::vector<Payload> checked_records(const char* log) {
    std::vector<Payload> records = test::read_records(test::recorded_data() / "rosbag2/extracted" / log);
    for (const Payload& payload : records) check<T>(payload);
    return records;
  }

  test::RandomValues values{random};
};

TEST_F(CorpusTest, ACloudThatARos2MiddlewareWrote) {
  const Payload payload =
      test::read_recording(test::recorded_data() / "cdr/pointcloud2_dds_message.bin").value();
  check<PointCloud2>(payload, 20);
  const Received<PointCloud2> received(payload);
  EXPECT_EQ(received.trailing().size(), 3U);

  const PointCloud2 cloud = received.decoded();
  EXPECT_EQ(cloud.header.stamp.sec, 1714506077);
  EXPECT_EQ(cloud.header.stamp.nanosec, 250967979U);
  EXPECT_EQ(cloud.header.frame_id, "lidar_link");
  EXPECT_EQ(cloud.height, 1U);
  EXPECT_EQ(cloud.width, 64'000U);
  EXPECT_EQ(cloud.point_step, 26U);
  EXPECT_EQ(cloud.row_step, 1'664'000U);
  EXPECT_EQ(cloud.data.size(), 1'664'000U);
  EXPECT_FALSE(cloud.is_bigendian);
  EXPECT_FALSE(cloud.is_dense);

  int without_return = 0;
  std::uint16_t highest_ring = 0;
  for (std::size_t at = 0; at < cloud.data.size(); at += cloud.point_step) {
    without_return +=
        value_at<float>(cloud.data, at) == 0 && value_at<float>(cloud.data, at + 4) == 0 ? 1 : 0;
    highest_ring = std::max(highest_ring, value_at<std::uint16_t>(cloud.data, at + 16));
  }
  EXPECT_EQ(without_return, 4578);
  EXPECT_EQ(highest_ring, 31);
}

TEST_F(CorpusTest, ViewsOfThatCloudReadTheSameWithoutDecodingIt) {
  const Received<PointCloud2> received(
      test::read_recording(test::recorded_data() / "cdr/pointcloud2_dds_message.bin").value());
  const PointCloud2 cloud = received.decoded();
  const auto view = received.view();
  EXPECT_EQ(view.header().stamp().nanosec(), 250967979U);
  EXPECT_EQ(view.header().frame_id(), "lidar_link");
  EXPECT_EQ(view.width(), 64'000U);
  EXPECT_TRUE(std::ranges::equal(view.data(), cloud.data));
  std::vector<std::string> fields;
  for (const auto field : view.fields()) {
    fields.push_back(std::string(field.name()) + " " + std::to_string(field.offset()));
  }
  EXPECT_EQ(fields,
            (std::vector<std::string>{"x 0", "y 4", "z 8", "intensity 12", "ring 16", "timestamp 18"}));
}

struct OusterScan {
  const char* file;
  std::uint32_t nanosec;
  int returns;
  std::uint32_t latest_ns;
};

void PrintTo(const OusterScan& scan, std::ostream* out) { *out << scan.file; }

class OusterCorpusTest : public CorpusTest, public ::testing::WithParamInterface<OusterScan> {};

TEST_P(OusterCorpusTest, AScanOf128Times1024Points) {
  const auto& [file, nanosec, expected_returns, expected_latest_ns] = GetParam();
  const std::optional<Payload> payload =
      test::read_recording(test::recorded_data() / "lidar3d/ouster" / file);
  if (!payload) GTEST_SKIP() << "xz is needed to unpack " << file;
  check<PointCloud2>(*payload, 10);
  const Received<PointCloud2> received(*payload);
  EXPECT_TRUE(received.trailing().empty());

  const PointCloud2 cloud = received.decoded();
  EXPECT_EQ(cloud.header.stamp.sec, 991);
  EXPECT_EQ(cloud.header.stamp.nanosec, nanosec);
  EXPECT_EQ(cloud.header.frame_id, "os_lidar");
  EXPECT_EQ(cloud.height, 128U);
  EXPECT_EQ(cloud.width, 1024U);
  ASSERT_EQ(cloud.fields.size(), 9U);
  EXPECT_EQ(cloud.fields[8].name, "range");
  EXPECT_EQ(cloud.fields[8].offset, 32U);
  EXPECT_EQ(cloud.point_step, 48U);
  EXPECT_TRUE(cloud.is_dense);
  ASSERT_EQ(cloud.data.size(), 6'291'456U);

  int returns = 0;
  std::uint32_t latest_ns = 0;
  for (std::size_t at = 0; at < cloud.data.size(); at += cloud.point_step) {
    returns += value_at<std::uint32_t>(cloud.data, at + 32) != 0 ? 1 : 0;
    latest_ns = std::max(latest_ns, value_at<std::uint32_t>(cloud.data, at + 20));
  }
  EXPECT_EQ(returns, expected_returns);
  EXPECT_EQ(latest_ns, expected_latest_ns);
}

INSTANTIATE_TEST_SUITE_P(
    Frame, OusterCorpusTest,
    ::testing::Values(OusterScan{"pointcloud2_0.cdr", 587'364'520, 107'647, 99'851'390},
                      OusterScan{"pointcloud2_1.cdr.xz", 687'315'250, 107'357, 99'911'550},
                      OusterScan{"pointcloud2_2.cdr.xz", 787'323'080, 107'532, 99'979'000}));

TEST_F(CorpusTest, LaserScansOfADrivingRobot) {
  std::size_t no_return = 0;
  const std::vector<Payload> records = checked_records<LaserScan>("neato_obstacle-avoider__scan.cdrlog");
  EXPECT_EQ(records.size(), 153U);
  for (const Payload& payload : records) {
    EXPECT_EQ(payload.size(), 2956U);
    const LaserScan scan = Received<LaserScan>(payload).decoded();
    EXPECT_EQ(scan.header.frame_id, "base_laser_link");
    EXPECT_EQ(scan.ranges.size(), 361U);
    EXPECT_EQ(scan.intensities, std::vector<float>(361, 10.0F));
    EXPECT_FLOAT_EQ(scan.range_min, 0.02F);
    EXPECT_FLOAT_EQ(scan.range_max, 5.0F);
    no_return +=
        static_cast<std::size_t>(std::ranges::count_if(scan.ranges, [](float r) { return std::isinf(r); }));
  }
  EXPECT_EQ(no_return, 51'872U);
}

TEST_F(CorpusTest, TheSameScansStabilised) {
  EXPECT_EQ(checked_records<LaserScan>("neato_obstacle-avoider__stable_scan.cdrlog").size(), 153U);
}

TEST_F(CorpusTest, SmallCloudsSomeOfThemWithoutAnyPoint) {
  std::size_t points = 0;
  int empty = 0;
  const std::vector<Payload> records =
      checked_records<PointCloud2>("neato_obstacle-avoider__projected_stable_scan.cdrlog");
  EXPECT_EQ(records.size(), 153U);
  for (const Payload& payload : records) {
    const Received<PointCloud2> received(payload);
    EXPECT_EQ(received.trailing().size(), 3U);
    const PointCloud2 cloud = received.decoded();
    EXPECT_EQ(cloud.data.size(), cloud.width * std::size_t{20});
    points += cloud.width;
    empty += cloud.width == 0 ? 1 : 0;
  }
  EXPECT_EQ(points, 3361U);
  EXPECT_EQ(empty, 8);
}

TEST_F(CorpusTest, OdometryOfADrivingRobot) {
  const std::vector<Payload> records = checked_records<Odometry>("neato_obstacle-avoider__odom.cdrlog");
  EXPECT_EQ(records.size(), 166U);
  for (const Payload& payload : records) {
    EXPECT_EQ(payload.size(), 724U);
    const Received<Odometry> received(payload);
    const Odometry odometry = received.decoded();
    EXPECT_EQ(odometry.header.frame_id, "odom");
    EXPECT_EQ(odometry.child_frame_id, "base_footprint");
    const auto& q = odometry.pose.pose.orientation;
    EXPECT_NEAR(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w, 1, 1e-6);
    EXPECT_EQ(received.view().pose().pose().orientation().w(), q.w);
  }
}

TEST_F(CorpusTest, BatteryStates) {
  const std::vector<Payload> records = checked_records<BatteryState>("plotjuggler_test__battery.cdrlog");
  EXPECT_EQ(records.size(), 1565U);
  for (const Payload& payload : records) {
    EXPECT_EQ(payload.size(), 104U);
    const BatteryState battery = Received<BatteryState>(payload).decoded();
    EXPECT_EQ(battery.header.frame_id, "it_works!!");
    EXPECT_LE(std::abs(battery.voltage), 1);
    EXPECT_EQ(battery.temperature, 2);
    EXPECT_EQ(battery.current, 3);
    EXPECT_EQ(battery.charge, 4);
    EXPECT_EQ(battery.capacity, 6);
    EXPECT_EQ(battery.design_capacity, 7);
    EXPECT_EQ(battery.percentage, 8);
    EXPECT_EQ(battery.power_supply_status, 9);
    EXPECT_EQ(battery.power_supply_health, 0);
    EXPECT_EQ(battery.power_supply_technology, 10);
    EXPECT_TRUE(battery.present);
    EXPECT_EQ(battery.cell_voltage, (std::vector<float>{5, 6, 7}));
    EXPECT_TRUE(battery.cell_temperature.empty());
    EXPECT_EQ(battery.location, "noth_pole");
    EXPECT_EQ(battery.serial_number, "666");
  }
}

}  // namespace
}  // namespace sft
