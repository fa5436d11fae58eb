// The messages of the experiments.
#pragma once

#include <filesystem>

#include "bench/common/message_set.h"

namespace sft::bench::paper {

/// Messages of the parametric study. REQUIRES: the paper has them.
SharedMessages parametric_messages(std::size_t fields, std::size_t field_bytes);
/// 360 ranges and as many intensities.
SharedMessages laser_scans();
SharedMessages battery_states();
/// 100 x 100 cells.
SharedMessages occupancy_grids();
/// 16 kB of points.
SharedMessages point_clouds();

// Messages that others recorded, from files below `data`; null if these are not there.

/// Scans of a robot's laser, 361 ranges and as many intensities.
SharedMessages recorded_laser_scans(const std::filesystem::path& data);
SharedMessages recorded_battery_states(const std::filesystem::path& data);
/// The map of a building.
SharedMessages recorded_occupancy_grids(const std::filesystem::path& data);
/// The first points of a rotating lidar's cloud, 16 kB of them.
SharedMessages recorded_point_clouds(const std::filesystem::path& data);

}  // namespace sft::bench::paper
