// expect: a_field_has_two_parts
#include "tests/compile_fail/cloud.h"

constexpr sft::Req<PointCloud2> declared = F::data.channels<"x"> | F::data.every(2);
