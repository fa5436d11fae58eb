// Reads what --input names: a file, or a directory of files, of any of the formats that the demo knows by
// their extension.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tools/demo/clouds/input_cloud.h"

namespace sft::demo {

struct Input {
  std::vector<InputCloud> clouds;
  std::vector<std::string> notes;  ///< which files were used and which not, one sentence each
};

/// The first `clouds_max` clouds at most. A directory is read in the order of the names; encoded messages are
/// preferred to other formats if both are there, since these are usually the same points again. Errors name
/// the file.
Result<Input> read_point_clouds(const std::filesystem::path& path, std::size_t clouds_max);

}  // namespace sft::demo
