#include <cstring>
#include <nav_msgs/msg/OccupancyGrid.hpp>
#include <sensor_msgs/msg/BatteryState.hpp>
#include <sensor_msgs/msg/LaserScan.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "bench/selection/selection.h"
#include "bench/typesupport/messages.h"
#include "core/seam/gate.h"
#include "sft/detail/project.h"
#include "tests/support/grey_map.h"
#include "tests/support/recorded_data.h"

namespace sft::bench {

namespace {

using nav_msgs::msg::OccupancyGrid;
using sensor_msgs::msg::BatteryState;
using sensor_msgs::msg::LaserScan;

constexpr std::size_t encapsulation_bytes = 4;

/// Returns the bytes of the body of an encoded message that has this part of a field, and all other fields
/// whole.
template <class T>
double bytes_of_part(const detail::SampleState& message, const std::string& part) {
  const TypeSupport& type = type_support<T>();
  const Selection parsed = type.parse_selection(part).value();
  const auto parts = parsed.parts();
  const Selection all = Selection::make(type.full(), {parts.begin(), parts.end()}, {}).value();
  const detail::ProjectionPlan plan(type, type.closed(all));
  detail::Projection projection;
  return projection.project(message, plan) ? static_cast<double>(projection.bytes()) : 0;
}

/// Counts the samples that pass the condition. The samples are voltages of a flight, one row of the file
/// for each 10 ms.
Figure voltage_on_change(const std::filesystem::path& file) {
  const TypeSupport& type = type_support<BatteryState>();
  const Selection selection = type.parse_selection("voltage @ changed 1%").value();
  core::Gate gate(0, detail::Conditions(type.type(), selection.gate().conditions), selection.gate_hash());
  gate.reader_begins();
  const test::Payload table = test::read_recording(file).value();
  std::istringstream lines(std::string(reinterpret_cast<const char*>(table.data()), table.size()));
  std::string line;
  std::getline(lines, line);  // skips the names of the columns: x, y, z, voltage
  std::int64_t samples = 0, passed = 0;
  for (BatteryState message; std::getline(lines, line); ++samples) {
    constexpr std::int64_t period_ns = 10'000'000;
    message.voltage = std::stof(line.substr(line.rfind(',') + 1));
    const auto source = detail::FieldSource::of_message(&message);
    gate.consider(source, samples * period_ns);
    gate.made(source, samples * period_ns);
    passed += gate.passes() ? 1 : 0;
  }
  return {"recorded_voltage_on_change", static_cast<double>(passed), "samples", static_cast<double>(samples),
          "of a flight, for changed 1%"};
}

/// Returns the figure for every fourth beam, as a mean over all scans of a drive.
Figure every_4th_beam(const std::filesystem::path& file) {
  const TypeSupport& type = type_support<LaserScan>();
  const FieldMask full = type.full();
  std::vector<std::uint32_t> index(type.index_slots());
  double part = 0, whole = 0, scans = 0;
  for (const test::Payload& payload : test::read_records(file)) {
    const std::vector<std::byte> body(payload.begin() + encapsulation_bytes, payload.end());
    const detail::SampleState scan{.body = body.data(),
                                   .body_bytes = static_cast<std::uint32_t>(body.size()),
                                   .index = index.data(),
                                   .mask = &full};
    if (detail::build_index(scan, type.type(), index) != detail::WalkStatus::ok) continue;
    part += bytes_of_part<LaserScan>(scan, "ranges[::4], intensities[::4]");
    whole += static_cast<double>(body.size());
    ++scans;
  }
  return {"recorded_scan_every_4th", part / scans, "B", whole / scans, "whole scans of a drive"};
}

Figure window_of_map(const std::filesystem::path& file) {
  const OccupancyGrid map = test::grid_of(test::read_grey_map(file).value(), 0.05F);
  Sample whole(map);
  return {"recorded_map_window",
          bytes_of_part<OccupancyGrid>(whole.state(), "data[rows 400:600, columns 700:900]"), "B",
          static_cast<double>(whole.body().size()), "a whole map, for 10 x 10 m of it"};
}

}  // namespace

std::vector<Figure> parts_of_recordings() {
  const std::filesystem::path data = test::recorded_data();
  const auto voltage = data / "battery/crazyflie_Real_path_47.csv";
  const auto scans = data / "rosbag2/extracted/neato_obstacle-avoider__scan.cdrlog";
  const auto map = data / "maps/willow-full-0.05.pgm";
  std::vector<Figure> figures;
  if (exists(voltage)) figures.push_back(voltage_on_change(voltage));
  if (exists(scans)) figures.push_back(every_4th_beam(scans));
  if (exists(map)) figures.push_back(window_of_map(map));
  return figures;
}

}  // namespace sft::bench
