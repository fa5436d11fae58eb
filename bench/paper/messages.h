// The messages of the experiments.
#pragma once

#include <filesystem>

#include "bench/common/message_set.h"

namespace sft::bench::paper {

/// Returns messages of the parametric study. REQUIRES: the paper has messages of this size.
SharedMessages parametric_messages(std::size_t fields, std::size_t field_bytes);
/// Returns scans of 360 ranges and as many intensities.
SharedMessages laser_scans();
SharedMessages battery_states();
/// Returns grids of 100 x 100 cells.
SharedMessages occupancy_grids();
/// Returns clouds with 16 kB of points.
SharedMessages point_clouds();

// The following functions return recorded messages from files below `data`; null if the files do not exist.

/// Returns scans of a robot's laser, with 361 ranges and as many intensities.
SharedMessages recorded_laser_scans(const std::filesystem::path& data);
SharedMessages recorded_battery_states(const std::filesystem::path& data);
/// Returns the map of a building.
SharedMessages recorded_occupancy_grids(const std::filesystem::path& data);
/// Returns the first 16 kB of points of a rotating lidar's cloud.
SharedMessages recorded_point_clouds(const std::filesystem::path& data);

}  // namespace sft::bench::paper
