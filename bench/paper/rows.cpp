#include "bench/paper/rows.h"

namespace sft::bench::paper {

namespace {

// The maximum of SFT's bytes relative to the peers' bytes if all fields are sent.
constexpr double full_masks = 1.01;

bool is_parametric(const Case& of) { return of.name == "parametric"; }

Row parametric_row(int percent, double saving, double bound, const Published& published) {
  const std::string number = std::to_string(percent);
  return {
      .name = "bandwidth_" + number,
      .title = "requirement probability " + number + " %",
      .cases = [percent](const Case& of) { return is_parametric(of) && of.configuration.percent == percent; },
      .saving = saving,
      .bound = bound,
      .sends_all = percent == 100,
      .published = published};
}

Row named_row(const std::string& name, const std::string& title, std::optional<double> saving, double bound) {
  return {.name = name,
          .title = title,
          .cases = [name](const Case& of) { return of.name == name; },
          .saving = saving,
          .bound = bound,
          .sends_all = bound == full_masks};
}

}  // namespace

std::vector<Row> parametric_rows() {
  return {{.name = "bandwidth_mean",
           .title = "all configurations",
           .cases = is_parametric,
           .saving = 0.197,
           .bound = 1 - 0.197,
           .published = Published{521.8, 530.0, 425.7, 0.66, 0.96, 0.95}},
          parametric_row(50, 0.491, 1 - 0.491, {521.9, 529.9, 269.7, 0.66, 0.95, 0.94}),
          parametric_row(75, 0.214, 1 - 0.214, {521.9, 530.2, 416.7, 0.66, 0.96, 0.95}),
          parametric_row(90, 0.084, 1 - 0.084, {521.8, 530.0, 485.4, 0.66, 0.96, 0.96}),
          parametric_row(100, -0.002, full_masks, {521.8, 529.9, 531.0, 0.66, 0.96, 0.96})};
}

std::vector<Row> nav2_rows() {
  constexpr double scan = 0.431, battery = 0.465, battery_bound = 1 - 0.6;
  return {named_row("laserscan", "LaserScan without intensities", scan, 1 - scan),
          named_row("battery", "BatteryState, current", battery, battery_bound),
          named_row("occupancygrid", "OccupancyGrid, all fields", std::nullopt, full_masks),
          named_row("recorded_laserscan", "LaserScan, recorded", scan, 1 - scan),
          named_row("recorded_battery", "BatteryState, recorded", battery, battery_bound),
          named_row("recorded_occupancygrid", "OccupancyGrid, recorded map", std::nullopt, full_masks)};
}

std::vector<Row> point_cloud_rows() {
  constexpr double saving = 0.329;
  return {named_row("pointcloud2_aggregate", "PointCloud2, three receivers", saving, 1 - saving),
          named_row("recorded_pointcloud2_aggregate", "PointCloud2, recorded", saving, 1 - saving)};
}

}  // namespace sft::bench::paper
