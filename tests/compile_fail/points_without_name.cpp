// expect: points[(][)] takes the name of a channel for each type
#include "tests/compile_fail/cloud.h"

auto misuse(const sft::Sample<PointCloud2>& sample) { return sample->points<float, float>("x"); }
