// expect: to_owned.*(constraints not satisfied|[(][)] const)
#include "tests/compile_fail/cloud.h"

auto misuse(const sft::Sample<PointCloud2, ~F::data | F::data.every(4)>& sample) { return sample.to_owned(); }
