// Different sets of fields of a PointCloud2, for readers each of which asks for other fields.
#pragma once

#include <cstddef>
#include <string>

namespace sft::bench {

/// Returns small fields, another set for each number below 64, as text that begins with a comma or is empty.
std::string small_fields(std::size_t number);
/// Returns the same fields, and the data of the cloud.
std::string own_fields_and_data(std::size_t number);

}  // namespace sft::bench
