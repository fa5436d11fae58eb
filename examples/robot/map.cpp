// A map that viewers get whenever they come, and a viewer of a window of it.
#include <sft/sft.h>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <nav_msgs/msg/OccupancyGrid.hpp>

using namespace std::chrono_literals;
using nav_msgs::msg::OccupancyGrid;
using F = OccupancyGrid::Field;

int main() {
  sft::Node server = sft::Node::open({.name = "map_server"}).value();
  const sft::PublisherOptions kept{
      .reliability = sft::reliable, .durability = sft::transient_local, .history_depth = 1};
  auto maps = server.publisher<OccupancyGrid>("map", kept).value();
  OccupancyGrid map;
  map.info = {.resolution = 0.05F, .width = 200, .height = 100};
  map.data.assign(20'000, 0);
  map.data[50 * 200 + 100] = 100;
  maps.publish(map);

  sft::Node viewer = sft::Node::open({.name = "viewer", .transport = sft::TransportChoice::udp}).value();
  auto window = viewer
                    .subscriber<OccupancyGrid, F::info | F::data.rows(40, 60).columns(90, 110)>(
                        "map", {.reliability = sft::reliable, .durability = sft::transient_local})
                    .value();
  if (!window.wait(5s)) return std::puts("no map came"), 1;
  const auto part = window.take();
  const auto cells = part->data<std::int8_t>();
  if (!cells) return std::fprintf(stderr, "%s\n", cells.error().message.c_str()), 1;
  std::size_t walls = 0;
  for (const std::int8_t cell : *cells) walls += cell > 50;
  std::printf("%zu x %zu cells, %zu walls, origin %.2f %.2f\n", cells->rows(), cells->columns(), walls,
              part->info().origin().position().x(), part->info().origin().position().y());
}
