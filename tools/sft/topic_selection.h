// The form in which commands about recordings take a topic and a selection of its samples:
//
//   imu                                     whole samples
//   points{header.stamp, data{x,y,z}[::2]}  these fields, and parts of fields
//   points{data{x,y,z}}[::2]                the same part of a single field
//   battery{voltage}@changed 1%             only samples that fulfil the condition
#pragma once

#include <sft/result.h>
#include <string>
#include <string_view>

namespace sft::tool {

struct TopicSelection {
  std::string topic{};  ///< the name of the topic, without a leading slash
  std::string text{};   ///< the text for parse_selection(); empty: all fields
};

/// Returns an error that shows the text if it does not have the form. The selection itself is not checked,
/// because its meaning depends on the type.
Result<TopicSelection> parse_topic_selection(std::string_view text);

}  // namespace sft::tool
