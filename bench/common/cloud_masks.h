// Different sets of fields of a PointCloud2, for readers that each ask for others.
#pragma once

#include <cstddef>
#include <string>

namespace sft::bench {

/// A different set of small fields for each number below 64. It begins with a comma, or is empty.
std::string small_fields(std::size_t number);
/// Returns the same fields and the data of the cloud.
std::string own_fields_and_data(std::size_t number);

}  // namespace sft::bench
