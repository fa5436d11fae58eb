// Reads the input of the demo: a file, or a directory of files. The extension of a file tells its format.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tools/demo/clouds/input_cloud.h"

namespace sft::demo {

struct Input {
  std::vector<InputCloud> clouds;
  std::vector<std::string> notes;  ///< sentences about the files that were used, and those that were not
};

/// Reads the first `clouds_max` clouds at most. A directory is read in the order of the names. If it has
/// encoded messages and other formats, only the messages are read, since the others usually have the same
/// points again. Errors name the file.
Result<Input> read_point_clouds(const std::filesystem::path& path, std::size_t clouds_max);

}  // namespace sft::demo
