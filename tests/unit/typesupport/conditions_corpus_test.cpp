// Conditions over streams that others recorded: those samples pass that a plain reading of the specification
// names. Needs the recordings beside the repository.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <iostream>
#include <nav_msgs/msg/Odometry.hpp>
#include <sensor_msgs/msg/BatteryState.hpp>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "sft/detail/decode.h"
#include "sft/detail/sample_format.h"
#include "tests/support/asked.h"
#include "tests/support/gate_reference.h"
#include "tests/support/recorded_data.h"

namespace sft {
namespace {

using nav_msgs::msg::Odometry;
using sensor_msgs::msg::BatteryState;

template <class T>
struct Stamped {
  std::int64_t stamp_ns;
  T message;
};

/// The cells of a table with a line of names at its beginning.
std::vector<std::vector<std::string>> cells_of(const std::filesystem::path& file) {
  const test::Payload bytes = test::read_recording(file).value();
  std::istringstream text(std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
  std::vector<std::vector<std::string>> rows;
  std::string line, cell;
  std::getline(text, line);
  while (std::getline(text, line)) {
    std::vector<std::string>& row = rows.emplace_back();
    for (std::istringstream cells(line); std::getline(cells, cell, ',');) row.push_back(cell);
  }
  return rows;
}

class ConditionsCorpus : public ::testing::Test {
 protected:
  /// How many samples pass, the first one included; each has to be one that the reference names.
  template <class T>
  std::size_t passed(std::string_view text, const std::vector<Stamped<T>>& stream) {
    const TypeSupport& type = type_support<T>();
    const auto conditions = type.parse_selection(text).value().gate().conditions;
    const auto fields = test::single_fields(type.type());
    test::GateReference reference(conditions);
    test::Asked asked(type.type(), conditions);
    std::size_t count = 0;
    for (std::size_t i = 0; i < stream.size(); ++i) {
      const auto& [stamp_ns, message] = stream[i];
      const auto values = test::values_of(fields, &message);
      const bool expected = reference.holds(values, stamp_ns);
      const bool holds = asked.holds(&message, stamp_ns, type.full());
      if (i > 0) {
        EXPECT_EQ(holds, expected) << "sample " << i;
      }
      if (i > 0 && !holds) continue;
      reference.passed(values, stamp_ns);
      asked.passed(&message, stamp_ns, type.full());
      ++count;
    }
    std::cout << count << " of " << stream.size() << " samples pass: " << text << '\n';
    RecordProperty("samples", std::to_string(stream.size()));
    RecordProperty("passed", std::to_string(count));
    return count;
  }

  static std::filesystem::path path_of(std::string_view name) { return test::recorded_data() / name; }
};

TEST_F(ConditionsCorpus, AVoltageInFlightPassesWhenItHasChangedByOnePercent) {
  const auto file = path_of("battery/crazyflie_Real_path_47.csv");
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "there is no " << file;
  constexpr std::int64_t period_ns = 10'000'000;  // one row every 10 ms
  std::vector<Stamped<BatteryState>> stream;
  for (const auto& row : cells_of(file)) {
    const auto stamp_ns = static_cast<std::int64_t>(stream.size()) * period_ns;
    stream.push_back({stamp_ns, {}});
    stream.back().message.voltage = std::stof(row.at(3));
  }
  ASSERT_EQ(stream.size(), 13'393U);
  EXPECT_EQ(passed("voltage @ changed 1%", stream), 194U);
  EXPECT_GT(passed("voltage @ changed 1% or every 1 s", stream), 194U);
  EXPECT_LE(passed("voltage @ changed 1% and voltage < 3.7", stream), 194U);
}

TEST_F(ConditionsCorpus, ABatteryThatIsUsedPassesOnChangeAndAsAHeartbeat) {
  const auto file = path_of("battery/phone_scenario5_soc.csv");
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "there is no " << file;
  std::vector<Stamped<BatteryState>> stream;
  for (const auto& row : cells_of(file)) {
    stream.push_back({std::llround(std::stod(row.at(0)) * 1e9), {}});
    BatteryState& battery = stream.back().message;
    battery.percentage = std::stof(row.at(1)) / 100;
    const auto number = [&](std::size_t cell) {  // fields may be empty
      return cell >= row.size() || row[cell].empty() ? NAN : std::stof(row[cell]);
    };
    battery.voltage = number(2) / 1000;
    battery.temperature = number(3) / 10;
  }
  ASSERT_EQ(stream.size(), 205U);
  const std::size_t on_change = passed("percentage @ changed 1%", stream);
  const std::size_t with_heartbeat = passed("percentage @ changed 1% or every 10 s", stream);
  EXPECT_GE(with_heartbeat, on_change);
  EXPECT_LT(on_change, stream.size() / 2);
  passed("* @ temperature > 35 or changed(voltage, temperature) 0.5%", stream);
}

TEST_F(ConditionsCorpus, ARobotPassesWhenItHasMoved) {
  const auto file = path_of("rosbag2/extracted/neato_obstacle-avoider__odom.cdrlog");
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "there is no " << file;
  const StructType& type = type_support<Odometry>().type();
  const FieldMask full = type_support<Odometry>().full();
  std::vector<Stamped<Odometry>> stream;
  for (const test::Payload& payload : test::read_records(file)) {
    const std::vector<std::byte> body(payload.begin() + detail::encapsulation_bytes, payload.end());
    std::vector<std::uint32_t> index(detail::slot_count(type));
    const detail::SampleState state{.body = body.data(),
                                    .body_bytes = static_cast<std::uint32_t>(body.size()),
                                    .index = index.data(),
                                    .mask = &full};
    ASSERT_EQ(detail::build_index(state, type, index), detail::WalkStatus::ok);
    Odometry& odometry = stream.emplace_back().message;
    ASSERT_EQ(detail::decode(state, type, &odometry), detail::WalkStatus::ok);
    const auto& stamp = odometry.header.stamp;
    stream.back().stamp_ns = std::int64_t{stamp.sec} * 1'000'000'000 + stamp.nanosec;
  }
  ASSERT_EQ(stream.size(), 166U);
  const std::size_t moved =
      passed("* @ changed(pose.pose.position.x, pose.pose.position.y) 0.05 or every 2 s", stream);
  EXPECT_GT(moved, 10U);
  EXPECT_LT(moved, stream.size());
  passed("* @ changed(child_frame_id) or twist.twist.angular.z > 0.1 and every 4th", stream);
}

}  // namespace
}  // namespace sft
