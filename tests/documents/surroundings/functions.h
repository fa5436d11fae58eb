// Surrounds functions in a block of a document. The functions are at namespace scope in a source file.
#include <sft/sft.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <iostream>
#include <nav_msgs/msg/Odometry.hpp>
#include <optional>
#include <sensor_msgs/msg/Image.hpp>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <span>
#include <string>
#include <thread>
#include <vector>

namespace sft_document {

using namespace std::chrono_literals;
using sensor_msgs::msg::PointCloud2;
using F = PointCloud2::Field;

#include BLOCK

}  // namespace sft_document
