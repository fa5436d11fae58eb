// Different sets of fields of a PointCloud2, for readers with different requests.
#pragma once

#include <cstddef>
#include <string>

namespace sft::bench {

/// Returns a set of small fields, a different set for each number less than 64. The text begins with a
/// comma or is empty.
std::string small_fields(std::size_t number);
/// Returns the fields of small_fields(number) and the data of the cloud.
std::string own_fields_and_data(std::size_t number);

}  // namespace sft::bench
