#include "sft/points.h"

#include <array>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

#include "bench/common/contest.h"
#include "bench/common/process.h"
#include "bench/selection/local_part.h"
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

/// Returns the cloud with coordinates in its points.
PointCloud2 cloud_of_values() {
  PointCloud2 cloud = ouster_cloud();
  for (std::size_t i = 0; i < cloud.data.size(); i += cloud.point_step) {
    const std::array<float, 3> xyz{static_cast<float>(i % 100), static_cast<float>(i % 77), 0.5F};
    std::memcpy(cloud.data.data() + i, xyz.data(), sizeof xyz);
  }
  return cloud;
}

/// The loop of a program that knows the offsets of x, y and z, and that rows follow one another.
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

/// Measures a reader on the publisher's host that requests three channels: the time to take the part and to
/// release it, and the time to read its points.
std::vector<Figure> part_in_place(const Sample& whole, int rounds) {
  LocalPart part(type_support<PointCloud2>(), whole, "data{x,y,z}");
  const auto best = best_times_ns(
      {batch_of([&] { part.take_and_release(); }), batch_of([&] { keep(part.copied()->data); })}, rounds);
  const View in_place = view_of<PointCloud2, all<PointCloud2>>(part.state());
  const View full = view_of<PointCloud2, all<PointCloud2>>(whole.state());
  if (sums_of_points(in_place) != sums_by_hand(full)) std::abort();
  const auto loops = best_times_ns(
      {batch_of([&] { keep(sums_of_points(in_place)); }), batch_of([&] { keep(sums_by_hand(full)); })},
      rounds);
  return {{"part_in_place", best[0] / 1000, "us", best[1] / 1000, "a copy of the part", 0.1},
          {"points_view_in_place", loops[0] / 1000, "us", loops[1] / 1000,
           "a loop by hand that sums x, y and z", 1.1}};
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
  std::vector<Figure> figures = part_in_place(whole, rounds);
  figures.push_back(time_of(whole.state(), "points_view_full", rounds));
  figures.push_back(time_of(packed, "points_view_packed", rounds));
  return figures;
}

}  // namespace sft::bench
