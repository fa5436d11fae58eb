#include <fields.h>
#include <nav_msgs/msg/OccupancyGrid.h>
#include <sensor_msgs/msg/BatteryState.h>
#include <sensor_msgs/msg/LaserScan.h>
#include <sensor_msgs/msg/PointCloud2.h>

#include <fields.hpp>
#include <nav_msgs/msg/OccupancyGrid.hpp>
#include <numbers>
#include <sensor_msgs/msg/BatteryState.hpp>
#include <sensor_msgs/msg/LaserScan.hpp>

#include "bench/common/cloud.h"
#include "bench/paper/messages.h"

namespace sft::bench::paper {

namespace {

template <class T>
SharedMessages zeros(const dds_topic_descriptor_t& cyclone_type) {
  return shared(std::vector<T>(1), cyclone_type);
}

}  // namespace

SharedMessages parametric_messages(std::size_t fields, std::size_t field_bytes) {
  using namespace sft_bench::paper;
  if (fields == 5) {
    if (field_bytes == 128) return zeros<Five128>(sft_bench_paper_Five128_desc);
    if (field_bytes == 256) return zeros<Five256>(sft_bench_paper_Five256_desc);
    return zeros<Five512>(sft_bench_paper_Five512_desc);
  }
  if (field_bytes == 128) return zeros<Seven128>(sft_bench_paper_Seven128_desc);
  if (field_bytes == 256) return zeros<Seven256>(sft_bench_paper_Seven256_desc);
  return zeros<Seven512>(sft_bench_paper_Seven512_desc);
}

SharedMessages laser_scans() {
  constexpr std::size_t beams = 360;
  sensor_msgs::msg::LaserScan scan{.header = header("base_scan")};
  scan.angle_max = 2 * std::numbers::pi_v<float>;
  scan.angle_increment = scan.angle_max / beams;
  scan.scan_time = 0.1F;
  scan.range_min = 0.12F;
  scan.range_max = 3.5F;
  for (std::size_t i = 0; i < beams; ++i) {
    scan.ranges.push_back(1 + static_cast<float>(i % 90) / 50);
    scan.intensities.push_back(static_cast<float>(i % 47) * 100);
  }
  return shared(std::vector{scan}, sensor_msgs_msg_LaserScan_desc);
}

SharedMessages battery_states() {
  sensor_msgs::msg::BatteryState state{.header = header("battery")};
  state.voltage = 25.1F;
  state.temperature = 31;
  state.current = -2.4F;
  state.charge = 8.6F;
  state.capacity = 10;
  state.design_capacity = 10;
  state.percentage = 0.86F;
  state.present = true;
  state.cell_voltage.assign(6, 4.18F);
  state.cell_temperature.assign(6, 31);
  state.location = "slot 1";
  state.serial_number = "BAT-000042";
  return shared(std::vector{state}, sensor_msgs_msg_BatteryState_desc);
}

SharedMessages occupancy_grids() {
  nav_msgs::msg::OccupancyGrid grid{.header = header("map")};
  grid.info.resolution = 0.05F;
  grid.info.width = 100;
  grid.info.height = 100;
  for (std::size_t i = 0; i < 10'000; ++i)
    grid.data.push_back(static_cast<std::int8_t>(i % 13 == 0 ? 100 : 0));
  return shared(std::vector{grid}, nav_msgs_msg_OccupancyGrid_desc);
}

SharedMessages point_clouds() { return shared(std::vector{cloud(16'000)}, sensor_msgs_msg_PointCloud2_desc); }

}  // namespace sft::bench::paper
