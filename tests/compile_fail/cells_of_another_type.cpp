// expect: the field has cells of another type, which is that of its elements
#include "tests/compile_fail/cloud.h"

auto misuse(const sft::Sample<sensor_msgs::msg::LaserScan>& sample) {
  return sample->ranges<std::uint32_t>();
}
