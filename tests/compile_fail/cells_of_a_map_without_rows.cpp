// expect: the declared mask lacks a field that the cells need: add the numbers of rows and columns
#include "tests/compile_fail/cloud.h"

#include <nav_msgs/msg/OccupancyGrid.hpp>
using nav_msgs::msg::OccupancyGrid;

constexpr sft::Mask<OccupancyGrid> declared = OccupancyGrid::Field::data | OccupancyGrid::Field::info.width;

auto misuse(const sft::Sample<OccupancyGrid, declared>& sample) { return sample->data<std::int8_t>(); }
