// Messages made from recorded maps, which are grey images.
#pragma once

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nav_msgs/msg/OccupancyGrid.hpp>
#include <optional>
#include <sensor_msgs/msg/Image.hpp>
#include <string>
#include <vector>

namespace sft::test {

struct GreyMap {
  std::uint32_t width = 0, height = 0;
  std::vector<std::uint8_t> grey;  ///< the pixels row by row, the top row first
};

/// Reads a file in the binary PGM format with the greatest value 255 (netpbm, pgm(5)). Returns nothing if the
/// file has another format.
inline std::optional<GreyMap> read_grey_map(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  const auto next = [&file] {
    std::string word;
    while (file >> word && word.starts_with('#')) std::getline(file, word);
    return word;
  };
  if (next() != "P5") return std::nullopt;
  GreyMap map;
  map.width = static_cast<std::uint32_t>(std::stoul(next()));
  map.height = static_cast<std::uint32_t>(std::stoul(next()));
  if (next() != "255") return std::nullopt;
  file.get();
  map.grey.resize(std::size_t{map.width} * map.height);
  file.read(reinterpret_cast<char*>(map.grey.data()), static_cast<std::streamsize>(map.grey.size()));
  return file ? std::optional(std::move(map)) : std::nullopt;
}

/// Returns the grid that a map server would make of the map. The first row of the grid is the lowest row of
/// the map.
inline nav_msgs::msg::OccupancyGrid grid_of(const GreyMap& map, float resolution) {
  constexpr std::uint8_t free = 254, occupied = 0;
  nav_msgs::msg::OccupancyGrid grid;
  grid.header.frame_id = "map";
  grid.info.resolution = resolution;
  grid.info.width = map.width;
  grid.info.height = map.height;
  for (std::uint32_t row = map.height; row-- > 0;) {
    const auto begin = map.grey.begin() + std::ptrdiff_t{row} * map.width;
    std::transform(begin, begin + map.width, std::back_inserter(grid.data), [](std::uint8_t grey) {
      return static_cast<std::int8_t>(grey == free ? 0 : grey == occupied ? 100 : -1);
    });
  }
  return grid;
}

inline sensor_msgs::msg::Image image_of(const GreyMap& map) {
  return {.header = {},
          .height = map.height,
          .width = map.width,
          .encoding = "mono8",
          .is_bigendian = 0,
          .step = map.width,
          .data = map.grey};
}

}  // namespace sft::test
