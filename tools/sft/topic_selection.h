// A topic as the commands about recordings take it, with what is wanted of it:
//
//   imu                                     all of it
//   points{header.stamp, data{x,y,z}[::2]}  these fields, and parts of fields
//   points{data{x,y,z}}[::2]                the same part of a single field
//   battery{voltage}@changed 1%             and these samples
#pragma once

#include <sft/result.h>
#include <string>
#include <string_view>

namespace sft::tool {

struct TopicSelection {
  std::string topic{};  ///< without a slash in front
  std::string text{};   ///< what parse_selection() takes; empty: all
};

/// Returns an error that shows the text if it has no such form. What the selection means depends on a type,
/// and is not checked.
Result<TopicSelection> parse_topic_selection(std::string_view text);

}  // namespace sft::tool
