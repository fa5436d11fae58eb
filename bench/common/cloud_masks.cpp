#include "bench/common/cloud_masks.h"

namespace sft::bench {

std::string small_fields(std::size_t number) {
  std::string fields;
  for (const char* name : {"height", "width", "is_bigendian", "point_step", "row_step", "is_dense"}) {
    if (number % 2 == 1) fields += std::string(", ") + name;
    number /= 2;
  }
  return fields;
}

std::string own_fields_and_data(std::size_t number) { return "data" + small_fields(number); }

}  // namespace sft::bench
