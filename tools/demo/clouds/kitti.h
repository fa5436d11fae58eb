// Scans as the KITTI dataset has them (.bin): points of four little-endian floats x, y, z, intensity, and
// nothing else.
#pragma once

#include "tools/demo/clouds/input_cloud.h"

namespace sft::demo {

Result<std::vector<InputCloud>> read_kitti(std::span<const std::byte> file, std::size_t limit);

}  // namespace sft::demo
