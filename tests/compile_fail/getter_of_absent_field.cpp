// expect: (no matching function for call to .*::height[(]|function 'height': constraints not satisfied)
// expect: field_is_in_declared_mask
#include "tests/compile_fail/cloud.h"

auto misuse(const sft::Sample<PointCloud2, F::width>& sample) { return sample->height(); }
