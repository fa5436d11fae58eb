// expect: (no matching function for call to .*::count[(]|function 'count': constraints not satisfied)
// expect: field_is_in_declared_mask
#include "tests/compile_fail/cloud.h"

std::uint32_t misuse(const sft::Sample<PointCloud2, F::fields.each.name>& sample) {
  std::uint32_t sum = 0;
  for (const auto field : sample->fields()) sum += field.count();
  return sum;
}
