// expect: only the data of a PointCloud2 has channels
#include "tests/compile_fail/cloud.h"

constexpr sft::Req<sensor_msgs::msg::LaserScan> declared =
    sensor_msgs::msg::LaserScan::Field::ranges.channels<"x">;
