// expect: (this_field_is_not_declared::name_it_where_the_subscriber_is_opened .*::height[(]|call to deleted
// .*'height') expect: this_field_is_not_declared
#include "tests/compile_fail/cloud.h"

auto misuse(const sft::Sample<PointCloud2, F::width>& sample) { return sample->height(); }
