// Samples as YAML, for people and for parsers of YAML, and messages from YAML.
//
//   header:
//     stamp:
//       sec: 7
//       nanosec: 0
//     frame_id: lidar
//   fields:
//   - name: x
//     offset: 0
//   data: [0, 97, 194]  # ... 997 more
//
// Fields that are not in the sample are left out. A sequence of structs of which only the length was sent is
// written as `fields.size: 2`. Text is quoted if YAML demands it. Bytes in it that are not UTF-8 and control
// characters are escaped (\xff). Enumerations are names, or numbers if the value has no name.
//
// All functions are pure; any thread may call them. They allocate memory.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "sft/dynamic_view.h"
#include "sft/result.h"

namespace sft {

/// Options for writing YAML.
struct YamlOptions {
  /// The maximum number of elements that are written of each array and sequence. A comment gives the number
  /// of the elements that are left out.
  std::size_t elements_max = 128;
  std::size_t text_bytes_max = 4096;                ///< limit of the bytes that are written of each string
  bool units = false;                               ///< true: comments give the units of members
  std::size_t output_bytes_max = 64 * 1024 * 1024;  ///< limit of the text in bytes; a longer text is an error
};

/// Writes a whole sample, or any part of it that is present. Returns an error if the bytes are malformed.
Result<std::string> to_yaml(const DynamicView& view, const YamlOptions& options = {});

/// Turns one document of YAML into the JSON of the same message, which cdr_from_json() (json.h) takes and
/// checks. The type of the field decides how a scalar is read: in `frame_id: 7` the scalar is a text, in
/// `x: 7` a number. JSON is also YAML, and is returned unchanged. Returns an error if the text is not YAML,
/// if a mapping has a name twice, or if aliases would make a large text from a small one. The function is
/// meant for texts that people write, because it takes many times the memory and time that JSON takes.
Result<std::string> json_from_yaml(const StructType& type, std::string_view yaml);

}  // namespace sft
