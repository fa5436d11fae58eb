// expect: (no matching function for call to .*::frame_id[(]|function 'frame_id': constraints not satisfied)
// expect: field_is_in_declared_mask
#include "tests/compile_fail/cloud.h"

auto misuse(const sft::Sample<PointCloud2, F::header.stamp>& sample) { return sample->header().frame_id(); }
