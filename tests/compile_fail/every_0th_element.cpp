// expect: a_range_has_an_index_and_a_step
#include "tests/compile_fail/cloud.h"

constexpr sft::Req<PointCloud2> declared = F::data.every(0);
