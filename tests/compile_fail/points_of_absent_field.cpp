// expect: the declared mask lacks a field that points[(][)] needs
#include "tests/compile_fail/cloud.h"

constexpr sft::Mask<PointCloud2> declared =
    F::height | F::width | F::fields | F::data | F::is_bigendian | F::point_step;

auto misuse(const sft::Sample<PointCloud2, declared>& sample) { return sample->points<float>("x"); }
