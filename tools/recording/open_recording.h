// Opening recordings of any format.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "sft/dynamic_type.h"
#include "sft/result.h"
#include "tools/recording/recording.h"

namespace sft::recording {

/// Opens a file, or the only file of a folder that rosbag2 made. The error names what is wrong with it. A
/// file that was not finished opens; faults() says so.
Result<std::unique_ptr<Recording>> open_recording(const std::string& path);

/// The files of recordings below a folder that rosbag2 made, in their order; the path itself if it is a file.
Result<std::vector<std::string>> files_of(const std::string& path);

/// Makes the type from the definition in the file. Errc::unavailable if the file has none that can be read.
Result<DynamicType> type_of(const Schema& schema);

}  // namespace sft::recording
