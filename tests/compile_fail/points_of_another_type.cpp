// expect: points[(][)] takes the types of channels, which are those of sensor_msgs/PointField
#include "tests/compile_fail/cloud.h"

auto misuse(const sft::Sample<PointCloud2>& sample) { return sample->points<float, long>("x", "y"); }
