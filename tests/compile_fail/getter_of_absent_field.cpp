// expect: this_field_is_not_declared::name_it_.*::height[(]|call to deleted
// expect: this_field_is_not_declared
#include "tests/compile_fail/cloud.h"

auto misuse(const sft::Sample<PointCloud2, F::width>& sample) { return sample->height(); }
