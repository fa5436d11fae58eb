// expect: to_owned.*(constraints not satisfied|[(][)] const)
#include "tests/compile_fail/cloud.h"

auto misuse(const sft::Sample<PointCloud2, F::height>& sample) { return sample.to_owned(); }
