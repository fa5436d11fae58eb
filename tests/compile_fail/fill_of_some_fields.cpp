// expect: fill.. needs all fields: open the subscriber without a list of fields
#include "tests/compile_fail/cloud.h"

auto misuse(const sft::Sample<PointCloud2, F::height>& sample, PointCloud2& cloud) {
  return sample.fill(cloud);
}
