#include "sft/points.h"

#include <array>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

#include "bench/common/contest.h"
#include "bench/common/process.h"
#include "bench/selection/messages.h"
#include "bench/selection/selection.h"
#include "bench/typesupport/messages.h"
#include "sft/detail/project.h"

namespace sft::bench {

namespace {

using namespace detail;
using sensor_msgs::msg::PointCloud2;
using View = ViewOf<PointCloud2, all<PointCloud2>>;
using Sums = std::array<float, 3>;

/// The cloud with coordinates in it.
PointCloud2 cloud_of_values() {
  PointCloud2 cloud = ouster_cloud();
  for (std::size_t i = 0; i < cloud.data.size(); i += cloud.point_step) {
    const std::array<float, 3> xyz{static_cast<float>(i % 100), static_cast<float>(i % 77), 0.5F};
    std::memcpy(cloud.data.data() + i, xyz.data(), sizeof xyz);
  }
  return cloud;
}

/// The loop of a program that knows where x, y and z are, and that rows follow one another.
[[gnu::noinline]] Sums sums_by_hand(const View& view) {
  const std::uint8_t* point = view.data().data();
  const std::size_t step = view.point_step();
  Sums sums{};
  for (std::size_t left = std::size_t{view.height()} * view.width(); left > 0; --left) {
    std::array<float, 3> xyz;
    std::memcpy(xyz.data(), point, sizeof xyz);
    for (std::size_t i = 0; i < sums.size(); ++i) sums[i] += xyz[i];
    point += step;
  }
  return sums;
}

[[gnu::noinline]] Sums sums_of_points(const View& view) {
  Sums sums{};
  const auto points = view.points<float, float, float>("x", "y", "z");
  if (!points) return sums;
  for (const auto [x, y, z] : *points) {
    sums[0] += x;
    sums[1] += y;
    sums[2] += z;
  }
  return sums;
}

Figure time_of(const SampleState& state, std::string name, int rounds) {
  const View view = view_of<PointCloud2, all<PointCloud2>>(state);
  if (sums_of_points(view) != sums_by_hand(view)) std::abort();
  const auto best = best_times_ns(
      {batch_of([&] { keep(sums_of_points(view)); }), batch_of([&] { keep(sums_by_hand(view)); })}, rounds);
  return {std::move(name), best[0] / 1000, "us", best[1] / 1000, "a loop by hand that sums x, y and z", 1.1};
}

}  // namespace

std::vector<Figure> reading_points(int rounds) {
  pin_to_core(1);
  const TypeSupport& type = type_support<PointCloud2>();
  const Sample whole(cloud_of_values());
  const ProjectionPlan plan(type, type.closed(type.parse_selection("data{x,y,z}").value()));
  Projection projection;
  std::vector<std::uint64_t> part(projection.bytes_most(whole.state(), plan) / 8 + 1);
  if (!projection.project(whole.state(), plan, std::as_writable_bytes(std::span(part)))) return {};
  const Segment body = projection.segments().front();
  std::vector<std::uint32_t> index(slot_count(type.type()));
  const FieldMask mask = plan.mask();
  const SampleState packed{.body = body.data,
                           .body_bytes = static_cast<std::uint32_t>(body.bytes),
                           .index = index.data(),
                           .mask = &mask};
  if (build_index(packed, type.type(), index) != WalkStatus::ok) return {};
  return {time_of(whole.state(), "points_view_full", rounds), time_of(packed, "points_view_packed", rounds)};
}

}  // namespace sft::bench
