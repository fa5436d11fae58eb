// Opens recordings of any format.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "sft/dynamic_type.h"
#include "sft/result.h"
#include "tools/recording/recording.h"

namespace sft::recording {

/// Opens a file, or the only file in a folder that rosbag2 made. The error says what is wrong. An
/// unfinished file can be opened, and faults() reports it.
Result<std::unique_ptr<Recording>> open_recording(const std::string& path);

/// Returns the files of the recording in a folder that rosbag2 made, in their order. If `path` is a file,
/// returns only this path.
Result<std::vector<std::string>> files_of(const std::string& path);

/// Makes the type from the definition in the file. Returns Errc::unavailable if the file has no definition,
/// or none that can be read.
Result<DynamicType> type_of(const Schema& schema);

}  // namespace sft::recording
