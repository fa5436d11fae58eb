// expect: (this_field_is_not_declared::name_it_where_the_subscriber_is_opened .*::frame_id[(]|call to deleted
// .*'frame_id') expect: this_field_is_not_declared
#include "tests/compile_fail/cloud.h"

auto misuse(const sft::Sample<PointCloud2, F::header.stamp>& sample) { return sample->header().frame_id(); }
