// The recorded clouds of --input.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "sft/result.h"

namespace sft::demo {

/// What the lidar publishes.
struct Clouds {
  std::string name = "generated scene";     ///< for people: this, or a path
  std::string shape = "128 x 1024 points";  ///< the size of a cloud, for people
  /// Messages as DDS sends them, published one after the other, again and again; empty: the generated scene.
  std::vector<std::vector<std::byte>> payloads{};
};

/// Reads a file, or those of a directory in the order of their names, but no more than `clouds_max`. A file
/// (.cdr) has one sensor_msgs/PointCloud2: the encapsulation of little-endian CDR, and the body. The error
/// names the file.
Result<Clouds> read_point_clouds(const std::filesystem::path& path, std::size_t clouds_max);

}  // namespace sft::demo
