// expect: a_range_is_given_twice
#include "tests/compile_fail/cloud.h"

constexpr sft::Req<PointCloud2> declared = F::data.columns(0, 640).columns(10, 20);
