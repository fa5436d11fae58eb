// Gates over recorded streams pass the same samples as a plain implementation of the specification. Needs
// the recordings, which are not in the repository (recorded_data.h).
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <geometry_msgs/msg/PoseStamped.hpp>
#include <iostream>
#include <iterator>
#include <nav_msgs/msg/Odometry.hpp>
#include <numeric>
#include <sensor_msgs/msg/BatteryState.hpp>
#include <sensor_msgs/msg/Imu.hpp>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "core/seam/gate.h"
#include "sft/detail/decode.h"
#include "sft/detail/sample_format.h"
#include "tests/support/asked.h"
#include "tests/support/gate_reference.h"
#include "tests/support/recorded_data.h"

namespace sft {
namespace {

using geometry_msgs::msg::PoseStamped;
using nav_msgs::msg::Odometry;
using sensor_msgs::msg::BatteryState;
using sensor_msgs::msg::Imu;

template <class T>
struct Stamped {
  std::int64_t stamp_ns;
  T message;
};

/// Returns the cells of a table, without its first line, which has the names of the columns.
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

/// A rate limit as a number of coins. Periods begin at the multiples of the period. At the first sample
/// there is one coin. Each new period adds a coin, up to two coins. Each sample that passes costs a coin.
class RateReference {
 public:
  explicit RateReference(std::chrono::microseconds period) : period_ns_(period.count() * 1000) {}

  /// Returns true if there is a coin. Stamps must be positive and must not decrease.
  bool permits(std::int64_t stamp_ns) {
    if (period_ns_ == 0) return true;
    const std::int64_t period = stamp_ns / period_ns_;
    for (period_ = period_ < 0 ? period : period_; period_ < period; ++period_)
      coins_ = std::min(coins_ + 1, 2);
    return coins_ > 0;
  }
  void passed() { --coins_; }

 private:
  std::int64_t period_ns_;
  std::int64_t period_ = -1;  ///< the number of the latest period that has begun
  int coins_ = 1;
};

/// Returns the messages of a .cdrlog file, each with the stamp in its header.
template <class T>
std::vector<Stamped<T>> read_messages(const std::filesystem::path& file) {
  const StructType& type = type_support<T>().type();
  const FieldMask full = type_support<T>().full();
  std::vector<Stamped<T>> stream;
  for (const test::Payload& payload : test::read_records(file)) {
    const std::vector<std::byte> body(payload.begin() + detail::encapsulation_bytes, payload.end());
    std::vector<std::uint32_t> index(detail::slot_count(type));
    const detail::SampleState state{.body = body.data(),
                                    .body_bytes = static_cast<std::uint32_t>(body.size()),
                                    .index = index.data(),
                                    .mask = &full};
    T& message = stream.emplace_back().message;
    EXPECT_EQ(detail::build_index(state, type, index), detail::WalkStatus::ok);
    EXPECT_EQ(detail::decode(state, type, &message), detail::WalkStatus::ok);
    const auto& stamp = message.header.stamp;
    stream.back().stamp_ns = std::int64_t{stamp.sec} * 1'000'000'000 + stamp.nanosec;
  }
  return stream;
}

class ConditionsCorpus : public ::testing::Test {
 protected:
  /// Returns the indices of the samples that pass the gate. Expects the reference implementations to pass the
  /// same samples.
  template <class T>
  std::vector<std::size_t> passing(std::string_view text, const std::vector<Stamped<T>>& stream) {
    const TypeSupport& type = type_support<T>();
    const Selection selection = type.parse_selection(text).value();
    const auto& [conditions, least_period] = selection.gate();
    const auto fields = test::single_fields(type.type());
    test::GateReference reference(conditions);
    RateReference rate(least_period);
    test::Asked asked(type.type(), conditions);
    core::Gate gate = gate_of(type, selection);
    gate.reader_begins();
    std::vector<std::size_t> result;
    for (std::size_t i = 0; i < stream.size(); ++i) {
      const auto& [stamp_ns, message] = stream[i];
      const auto values = test::values_of(fields, &message);
      const bool fulfils = reference.holds(values, stamp_ns);
      const bool holds = asked.holds(&message, stamp_ns, type.full());
      EXPECT_EQ(holds, fulfils) << "sample " << i << " of " << text;
      const bool is_permitted = rate.permits(stamp_ns);
      const bool expected = fulfils && (reference.begins() || is_permitted);
      const auto source = detail::FieldSource::of_message(&message);
      gate.consider(source, stamp_ns);
      EXPECT_EQ(gate.passes(), expected) << "sample " << i << " of " << text;
      if (!expected) continue;
      gate.made(source, stamp_ns);
      reference.passed(values, stamp_ns);
      rate.passed();
      asked.passed(&message, stamp_ns, type.full());
      result.push_back(i);
    }
    EXPECT_EQ(gate.passed(), result.size()) << text;
    EXPECT_EQ(gate.withheld(), stream.size() - result.size()) << text;
    return result;
  }

  /// Returns the number of samples that pass.
  template <class T>
  std::size_t passed(std::string_view text, const std::vector<Stamped<T>>& stream) {
    const std::size_t count = passing(text, stream).size();
    std::cout << count << " of " << stream.size() << " samples pass: " << text << '\n';
    RecordProperty("samples", std::to_string(stream.size()));
    RecordProperty("passed", std::to_string(count));
    return count;
  }

  struct Expected {
    std::size_t count;  ///< the number of samples that pass
    std::string_view text;
  };
  template <class T>
  void expect_passed(const std::vector<Stamped<T>>& stream, const std::vector<Expected>& expected) {
    for (const auto& [count, text] : expected) EXPECT_EQ(passed(text, stream), count) << text;
  }

  /// Takes gates that pass a sample only after a change or after some time. Expects that a sample that is
  /// published twice passes once, and that all samples that passed a gate pass an equal gate.
  template <class T>
  void expect_none_passes_twice(const std::vector<Stamped<T>>& stream,
                                const std::vector<std::string_view>& texts) {
    std::vector<Stamped<T>> each_twice;
    for (const Stamped<T>& sample : stream) each_twice.insert(each_twice.end(), 2, sample);
    for (const std::string_view text : texts) {
      const std::vector<std::size_t> once = passing(text, stream);
      std::vector<std::size_t> firsts;
      std::vector<Stamped<T>> behind_the_gate;
      for (const std::size_t i : once) {
        firsts.push_back(2 * i);
        behind_the_gate.push_back(stream[i]);
      }
      EXPECT_EQ(passing(text, each_twice), firsts) << text;
      std::vector<std::size_t> all(once.size());
      std::iota(all.begin(), all.end(), std::size_t{0});
      EXPECT_EQ(passing(text, behind_the_gate), all) << text;
    }
  }

  static std::filesystem::path path_of(std::string_view name) { return test::recorded_data() / name; }

 private:
  static core::Gate gate_of(const TypeSupport& type, const Selection& selection) {
    const auto least_period_us = static_cast<std::uint32_t>(selection.gate().least_period.count());
    if (selection.gate().conditions.empty()) return core::Gate(least_period_us);
    return {least_period_us, detail::Conditions(type.type(), selection.gate().conditions),
            selection.without_rate().gate_hash()};
  }
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
    const auto number = [&](std::size_t cell) {  // a cell of the table may be empty
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
  const std::vector<Stamped<Odometry>> stream = read_messages<Odometry>(file);
  ASSERT_EQ(stream.size(), 166U);
  const std::size_t moved =
      passed("* @ changed(pose.pose.position.x, pose.pose.position.y) 0.05 or every 2 s", stream);
  EXPECT_GT(moved, 10U);
  EXPECT_LT(moved, stream.size());
  passed("* @ changed(child_frame_id) or twist.twist.angular.z > 0.1 and every 4th", stream);
}

// ---- battery states of autopilots ----

/// Returns the records of a PX4 autopilot about one battery or two, which `location` distinguishes.
std::vector<Stamped<BatteryState>> read_px4(const std::filesystem::path& file) {
  constexpr std::size_t instance = 1, voltage = 2, current = 4, remaining = 8, temperature = 10,
                        capacity = 12;
  std::vector<Stamped<BatteryState>> stream;
  for (const auto& row : cells_of(file)) {
    const auto number = [&row](std::size_t cell) { return std::stof(row.at(cell)); };
    stream.push_back({std::stoll(row.at(0)) * 1000, {}});
    BatteryState& battery = stream.back().message;
    battery.location = row.at(instance);
    battery.voltage = number(voltage);
    battery.current = number(current);
    battery.percentage = number(remaining);
    battery.temperature = number(temperature);  // the temperature was not measured: a NaN
    battery.capacity = number(capacity) / 1000;
  }
  return stream;
}

std::vector<Stamped<BatteryState>> at_location(const std::vector<Stamped<BatteryState>>& stream,
                                               std::string_view location) {
  std::vector<Stamped<BatteryState>> result;
  std::ranges::copy_if(stream, std::back_inserter(result), [location](const Stamped<BatteryState>& sample) {
    return sample.message.location == location;
  });
  return result;
}

TEST_F(ConditionsCorpus, TwoPacksOnOneTopicAreAlwaysAChangeForEachOther) {
  const auto file = path_of("battery/px4_cubeorange_battery_status.csv");
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "there is no " << file;
  const std::vector<Stamped<BatteryState>> both = read_px4(file);
  ASSERT_EQ(both.size(),
            // 21 samples of a pack with 23 V and 30 Ah, each followed by one of a pack with 50 V and 6 Ah.
            42U);
  expect_passed(both, {{42, "voltage @ changed 1%"},
                       // Passes on the change from 23 V to 50 V, but never on the way back.
                       {2, "voltage @ changed 60%"},
                       {42, "* @ changed(location)"},
                       {1, "* @ changed(temperature)"},
                       {42, "* @ temperature != 0"},
                       {0, "* @ temperature < 1000"},
                       {21, "* @ voltage > 40"},
                       {1, "voltage @ voltage > 40 and changed 1%"},
                       {11, "current @ voltage > 40 and changed 1"},
                       {9, "* @ every 5th"},
                       {8, "* @ capacity == 6 and every 3rd"},
                       // Each fourth sample is of the other pack, so only the first sample passes.
                       {1, "* @ capacity == 6 and every 4th"},
                       {6, "* @ every 1 s"},
                       {7, "* @ at most 1 Hz"},
                       {13, "* @ at most one per 500 ms"},
                       {7, "* @ voltage > 40 at most 1 Hz"}});
  expect_none_passes_twice(both, {"* @ changed(location)", "current @ voltage > 40 and changed 1",
                                  "* @ voltage < 40 and every 1 s", "* @ changed(location) at most 1 Hz"});
}

TEST_F(ConditionsCorpus, EachOfTwoPacksPassesByItsOwnChanges) {
  const auto file = path_of("battery/px4_cubeorange_battery_status.csv");
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "there is no " << file;
  const std::vector<Stamped<BatteryState>> both = read_px4(file);
  const auto large = at_location(both, "0"), small = at_location(both, "1");
  ASSERT_EQ(large.size(), 21U);
  ASSERT_EQ(small.size(), 21U);
  expect_passed(large, {{21, "voltage @ changed"},
                        {7, "voltage @ changed 0.05"},
                        {3, "voltage @ changed 0.1"},
                        {5, "voltage @ changed 0.3%"},
                        {17, "current @ changed 50%"},
                        {1, "current @ changed 1"},
                        {7, "percentage @ changed 0.01%"},
                        {2, "* @ current <= 0"},
                        {5, "* @ current > 0.5"},
                        {2, "* @ current > 0.2 and every 3rd"},
                        {7, "percentage @ changed 0.0001 or every 1 s"},
                        {7, "voltage @ changed 0.1% at most 1 Hz"}});
  expect_passed(small, {{21, "voltage @ changed"},
                        {17, "voltage @ changed 0.05"},
                        {9, "voltage @ changed 0.1"},
                        {4, "voltage @ changed 0.3%"},
                        {15, "current @ changed 50%"},
                        {11, "current @ changed 1"},
                        {5, "percentage @ changed 0.01%"},
                        {4, "* @ current <= 0"},
                        {15, "* @ current > 0.5"},
                        {6, "* @ current > 0.2 and every 3rd"},
                        {6, "percentage @ changed 0.0001 or every 1 s"},
                        {7, "voltage @ changed 0.1% at most 1 Hz"}});
  for (const auto& pack : {large, small})
    expect_none_passes_twice(
        pack, {"voltage @ changed 0.1", "current @ changed 50%", "* @ every 900 ms",
               "percentage @ changed 0.0001 or every 1 s", "voltage @ changed 0.1% at most 1 Hz"});
}

TEST_F(ConditionsCorpus, ABatteryOnTheBenchPassesWhenSomeCurrentFlows) {
  const auto file = path_of("battery/px4_fmu_v6c_battery_status.csv");
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "there is no " << file;
  const std::vector<Stamped<BatteryState>> stream = read_px4(file);
  ASSERT_EQ(stream.size(), 34U);
  expect_passed(stream, {{6, "* @ current > 0"},
                         {8, "* @ current > 0 or every 2 s"},
                         {10, "* @ current > 0 or every 1 s"},
                         {10, "current @ changed"},
                         {34, "voltage @ changed"},
                         {7, "voltage @ changed 1%"},
                         {3, "voltage @ changed 2%"},
                         {13, "voltage @ changed 0.1"},
                         {4, "voltage @ changed 1% and every 2nd"},
                         {9, "voltage @ changed 1% or every 10th"},
                         {3, "* @ voltage < 12.3"},
                         {19, "percentage @ changed"},
                         {4, "percentage @ changed 0.001%"},
                         {6, "* @ voltage < 12.3 or changed(percentage) 0.001%"},
                         {4, "* @ every 10th"},
                         {7, "* @ every 1 s"},
                         {7, "* @ at most 1 Hz"},
                         {4, "* @ at most one per 2 s"},
                         {33, "* @ at most 10 Hz"},
                         {5, "voltage @ changed 1% at most 1 Hz"}});
  expect_none_passes_twice(
      stream, {"current @ changed", "voltage @ changed 1%", "percentage @ changed 0.001%", "* @ every 1 s",
               "voltage @ changed 2% or every 2 s", "voltage @ changed 1% at most 1 Hz"});
}

// ---- messages of another implementation: one number follows a sine, 25 messages a second for 62.6 s ----

TEST_F(ConditionsCorpus, AVoltageThatSwingsPassesByHowFarItHasSwung) {
  const auto file = path_of("rosbag2/extracted/plotjuggler_test__battery.cdrlog");
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "there is no " << file;
  const auto stream = read_messages<BatteryState>(file);
  ASSERT_EQ(stream.size(), 1565U);
  expect_passed(stream,
                {{1565, "voltage @ changed"},
                 {563, "voltage @ changed 0.05"},
                 {60, "voltage @ changed 0.5"},
                 {20, "voltage @ changed 1.5"},
                 {1, "voltage @ changed 2"},  // the voltage stays between -1 and 1
                 {664, "voltage @ changed 10%"},
                 {226, "voltage @ changed 50%"},
                 {1, "* @ changed(temperature, serial_number, present)"},
                 {1565, "* @ temperature == 2 and present == true"},
                 {780, "* @ voltage > 0"},
                 {78, "* @ voltage > 0 and every 10th"},
                 {451, "* @ voltage > 0.9 or voltage < -0.9"},
                 {125, "* @ (voltage > 0.9 or voltage < -0.9) at most 5 Hz"},
                 {16, "* @ every 100th"},
                 {62, "* @ every 1 s"},  // the first and the last of 26 successive samples are 1.04 s apart
                 {7, "* @ every 10 s"},
                 {62, "voltage @ changed 1 or every 1 s"},
                 {64, "* @ at most 1 Hz"},
                 {627, "* @ at most 10 Hz"},
                 {1565, "* @ at most 25 Hz"},
                 {60, "voltage @ changed 0.5 at most 1 Hz"}});
  expect_none_passes_twice(
      stream, {"voltage @ changed", "voltage @ changed 10%", "voltage @ changed 0.5", "* @ every 10 s",
               "voltage @ changed 1 or every 1 s", "voltage @ changed 0.5 at most 1 Hz"});
}

TEST_F(ConditionsCorpus, AnOrientationPassesWhenItHasTurned) {
  const auto file = path_of("rosbag2/extracted/plotjuggler_test__imu.cdrlog");
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "there is no " << file;
  const auto stream = read_messages<Imu>(file);
  ASSERT_EQ(stream.size(), 1565U);
  expect_passed(stream, {{339, "orientation.x @ changed 0.1"},
                         {21, "orientation.x @ changed 1"},
                         {379, "orientation @ changed 25%"},  // the other three numbers do not change
                         {1, "* @ changed(angular_velocity.z, linear_acceleration.x)"},
                         {13, "* @ changed(angular_velocity.z) or every 5 s"},
                         {197, "* @ orientation.x >= 0 and every 4th"},
                         {100, "orientation.x @ orientation.x > 0.5 and changed 0.1 or every 3 s"}});
  expect_none_passes_twice(stream, {"orientation @ changed 25%", "orientation.x @ changed 0.1",
                                    "orientation.x @ orientation.x > 0.5 and changed 0.1 or every 3 s"});
}

TEST_F(ConditionsCorpus, APosePassesWhenItHasMoved) {
  const auto file = path_of("rosbag2/extracted/plotjuggler_test__pose.cdrlog");
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "there is no " << file;
  const auto stream = read_messages<PoseStamped>(file);
  ASSERT_EQ(stream.size(), 1565U);
  expect_passed(stream, {{338, "pose.position @ changed 0.1"},
                         {140, "pose.position @ changed 0.25"},
                         {117, "pose.position @ changed 0.25 at most 2 Hz"},
                         {20, "* @ changed(pose.position.x, pose.position.y) 1"},
                         {92, "* @ pose.position.x < -0.99 or every 2 s"},
                         {224, "* @ every 7th"}});
  expect_none_passes_twice(stream,
                           {"pose.position @ changed 0.1", "pose.position @ changed 0.25 at most 2 Hz"});
}

}  // namespace
}  // namespace sft
