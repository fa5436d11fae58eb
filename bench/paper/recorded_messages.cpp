#include <nav_msgs/msg/OccupancyGrid.h>
#include <sensor_msgs/msg/BatteryState.h>
#include <sensor_msgs/msg/LaserScan.h>
#include <sensor_msgs/msg/PointCloud2.h>

#include <algorithm>
#include <filesystem>
#include <nav_msgs/msg/OccupancyGrid.hpp>
#include <sensor_msgs/msg/BatteryState.hpp>
#include <sensor_msgs/msg/LaserScan.hpp>
#include <sensor_msgs/msg/PointCloud2.hpp>

#include "bench/common/cloud.h"
#include "bench/paper/messages.h"
#include "tests/support/grey_map.h"
#include "tests/support/recorded_data.h"

namespace sft::bench::paper {

namespace {

constexpr std::size_t encapsulation_bytes = 4;

/// Returns messages from the first records of a log.
template <class T>
SharedMessages logged(const std::filesystem::path& data, const char* name,
                      const dds_topic_descriptor_t& cyclone_type) {
  const std::filesystem::path file = data / "rosbag2/extracted" / name;
  if (!std::filesystem::exists(file)) return nullptr;
  constexpr std::size_t records_max = 50;
  std::vector<T> messages;
  for (const test::Payload& payload : test::read_records(file)) {
    if (messages.size() == records_max) break;
    if (auto message = decoded<T>(std::span(payload).subspan(encapsulation_bytes)))
      messages.push_back(*std::move(message));
  }
  return messages.empty() ? nullptr : shared(std::move(messages), cyclone_type);
}

}  // namespace

SharedMessages recorded_laser_scans(const std::filesystem::path& data) {
  return logged<sensor_msgs::msg::LaserScan>(data, "neato_obstacle-avoider__scan.cdrlog",
                                             sensor_msgs_msg_LaserScan_desc);
}

SharedMessages recorded_battery_states(const std::filesystem::path& data) {
  return logged<sensor_msgs::msg::BatteryState>(data, "plotjuggler_test__battery.cdrlog",
                                                sensor_msgs_msg_BatteryState_desc);
}

SharedMessages recorded_occupancy_grids(const std::filesystem::path& data) {
  const auto map = test::read_grey_map(data / "maps/depot.pgm");
  return map ? shared(std::vector{test::grid_of(*map, 0.05F)}, nav_msgs_msg_OccupancyGrid_desc) : nullptr;
}

SharedMessages recorded_point_clouds(const std::filesystem::path& data) {
  constexpr std::uint32_t bytes_max = 16'000;
  const std::filesystem::path file = data / "cdr/pointcloud2_dds_message.bin";
  if (!std::filesystem::exists(file)) return nullptr;
  const auto payload = test::read_recording(file);
  auto cloud =
      decoded<sensor_msgs::msg::PointCloud2>(std::span(payload.value()).subspan(encapsulation_bytes));
  if (!cloud || cloud->point_step == 0) return nullptr;
  cloud->width = bytes_max / cloud->point_step;
  cloud->row_step = cloud->width * cloud->point_step;
  cloud->data.resize(cloud->row_step);
  return shared(std::vector{*std::move(cloud)}, sensor_msgs_msg_PointCloud2_desc);
}

}  // namespace sft::bench::paper
