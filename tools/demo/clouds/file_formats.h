// The formats of files that the demo reads. Each function takes the contents of a file and returns `limit`
// clouds at most; its errors say what is wrong with the file, which the caller names.
#pragma once

#include "tools/demo/clouds/input_cloud.h"

namespace sft::demo {

/// Reads an encoded message (.cdr).
Result<std::vector<InputCloud>> read_cdr(std::span<const std::byte> file, std::size_t limit);
/// Reads a log of encoded messages (.cdrlog): per record a u64 of time in ns, a u32 of length, and that many
/// bytes; little-endian, and nothing else. The time is not used: the demo has a rate of its own.
Result<std::vector<InputCloud>> read_cdrlog(std::span<const std::byte> file, std::size_t limit);
/// Reads a scan of the KITTI dataset (.bin): points of four little-endian floats x, y, z, intensity, and
/// nothing else.
Result<std::vector<InputCloud>> read_kitti(std::span<const std::byte> file, std::size_t limit);
/// Reads a file of the Point Cloud Library (.pcd).
Result<std::vector<InputCloud>> read_pcd(std::span<const std::byte> file, std::size_t limit);

}  // namespace sft::demo
