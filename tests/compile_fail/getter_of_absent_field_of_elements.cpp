// expect: this_field_is_not_declared::name_it_.*::count[(]|call to deleted
// expect: this_field_is_not_declared
#include "tests/compile_fail/cloud.h"

std::uint32_t misuse(const sft::Sample<PointCloud2, F::fields.each.name>& sample) {
  std::uint32_t sum = 0;
  for (const auto field : sample->fields()) sum += field.count();
  return sum;
}
