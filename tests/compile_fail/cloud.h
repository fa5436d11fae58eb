// Declarations for the snippets of this folder.
#pragma once

#include <sft/sft.h>

#include <sensor_msgs/msg/Image.hpp>
#include <sensor_msgs/msg/LaserScan.hpp>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <tuple>

using sensor_msgs::msg::Image;
using sensor_msgs::msg::PointCloud2;
using F = PointCloud2::Field;
