// expect: the cells of this field have channels: read the points, sample->points<float>
#include "tests/compile_fail/cloud.h"

using Rgb = std::array<std::uint8_t, 3>;

auto misuse(const sft::Sample<PointCloud2, F::data>& sample) { return sample->data<Rgb>(); }
