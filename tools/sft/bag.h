// `sft bag`: lists the contents of recordings, checks and repairs them, and estimates how many bytes
// selections would have saved.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "tools/recording/open_recording.h"
#include "tools/sft/common_options.h"
#include "tools/sft/exit_code.h"
#include "tools/sft/output.h"
#include "tools/terminal/stop.h"

namespace sft::tool {

struct BagOptions {
  std::string what{};  ///< info, check, repair or estimate
  std::vector<std::string> files{};
  std::vector<std::string> like{};  ///< the selections of topics that an estimate applies
  std::string output{};             ///< the file that a repair writes
  std::string html{};               ///< the HTML file that an estimate writes; empty: no such file is written
};

ExitCode run(const BagOptions& options, const CommonOptions& common, Stop& stop, Output& output);

/// The types of recordings. Each type is made once, since many channels may have the same type.
class RecordedTypes {
 public:
  explicit RecordedTypes(const CommonOptions& common) : common_(common) {}

  /// Returns the type of a schema. Uses the definition in the recording. If the recording has no
  /// definition, uses the definition in the files of the user or of SFT. `file` is the number of the
  /// recording.
  const Result<DynamicType>& find(const recording::Schema& schema, std::size_t file = 0);

 private:
  const CommonOptions& common_;
  /// The types by number of the recording and id of the schema
  std::map<std::pair<std::size_t, std::uint16_t>, Result<DynamicType>> found_;
};

/// Runs `sft bag estimate` for one file.
ExitCode run_estimate(const BagOptions& options, const CommonOptions& common, recording::Recording& bag,
                      Stop& stop, Output& output);

}  // namespace sft::tool
