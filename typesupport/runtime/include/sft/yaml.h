// Samples as YAML, to be read by people and by YAML's parsers, and messages from YAML.
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
// What is not in the sample is left out; of a sequence of structs of which only the length was sent stands
// `fields.size: 2`. Text is quoted where YAML demands it; in it, bytes that are not UTF-8 and control
// characters are escaped (\xff). Enumerations are their names, or numbers where they have none.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "sft/dynamic_view.h"
#include "sft/result.h"

namespace sft {

/// Form and limits of a message as YAML.
struct YamlOptions {
  std::size_t elements_max =
      128;  ///< of each array and sequence; how many more there are stands in a comment
  std::size_t text_bytes_max = 4096;                ///< of each string, likewise
  bool units = false;                               ///< in comments
  std::size_t output_bytes_max = 64 * 1024 * 1024;  ///< more is an error
};

/// `view` is usually a whole sample, but may be any part of it that is there. An error if the bytes are not
/// what they claim to be.
Result<std::string> to_yaml(const DynamicView& view, const YamlOptions& options = {});

/// One document of YAML as the JSON of the same message, which cdr_from_json() takes (json.h) and checks: a
/// scalar is what the field needs that it stands for, so that `frame_id: 7` is text, and `x: 7` a number.
/// JSON is YAML, and comes back as it is. An error where the text is no YAML, where a name stands twice in
/// one mapping, and where aliases would make much of little. For people's texts: it takes memory, and time,
/// many times those of JSON.
Result<std::string> json_from_yaml(const StructType& type, std::string_view yaml);

}  // namespace sft
