// expect: (cannot convert|no viable conversion).*sft::Optional<unsigned int>
#include "tests/compile_fail/cloud.h"

std::uint32_t misuse(const sft::Sample<PointCloud2, sft::recorded>& sample) { return sample->width(); }
