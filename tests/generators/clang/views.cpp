// Uses samples as programs do, and includes all headers that programs may include.
#include <algorithm>
#include <ranges>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>

#include "all_headers.h"

using sensor_msgs::msg::PointCloud2;
using F = PointCloud2::Field;
using All = sft::Sample<PointCloud2>;
using Elements = decltype(std::declval<const All&>()->fields());

static_assert(std::ranges::random_access_range<Elements>);
static_assert(std::ranges::sized_range<Elements>);
static_assert(std::ranges::borrowed_range<Elements>);
static_assert(std::ranges::view<Elements>);
static_assert(std::is_trivially_copyable_v<Elements>);

std::uint32_t offset_of(const All& sample, std::string_view name) {
  const auto fields = sample->fields();
  if (!fields || fields.empty()) return 0;
  const auto found = std::ranges::find_if(fields, [&](const auto& field) { return field.name() == name; });
  std::uint32_t sum = fields.front().offset() + fields.back().offset() + fields[1].offset();
  for (const auto field : fields) sum += field.offset();
  return found == fields.end() ? sum : found->offset();
}

std::size_t read_when_recorded(const sft::Sample<PointCloud2, sft::recorded>& sample) {
  const auto data = sample->data();
  return data ? data->size() : 0;
}

static_assert(std::ranges::random_access_range<sft::Cells<std::tuple<float, double>>>);

float sum_of_points(const All& sample, const sft::Sample<PointCloud2, sft::recorded>& other) {
  float sum = 0;
  if (const auto points = sample->points<float, float>("x", "y")) {
    for (const auto [x, y] : *points) sum += x * y;
    sum += std::get<0>(points->at(0, 0)) + std::get<1>((*points)[1]);
  }
  if (const auto points = other->points<std::uint16_t>("ring"))
    for (const auto [ring] : *points) sum += ring;
  return sum;
}

int main() {
  auto node = sft::Node::open({.name = "clang", .threads = {.receiver = {.cpus = {0}}}});
  if (!node) return 1;
  auto publisher = node->publisher<PointCloud2>("points").value();
  auto declared = node->subscriber<PointCloud2, F::height | F::fields>("points").value();
  auto recorded = node->subscriber<PointCloud2, sft::recorded>(
      "points", [](const auto& sample) { read_when_recorded(sample); });
  auto loan = publisher.loan({.height = 1}, {.data = 100}).value();
  loan.set(F::width, 1024U);
  std::move(loan).publish();
  while (const auto sample = declared.take()) {
    if (sample->height() == 0 || sample->fields().size() == 0) return 2;
  }
  const All whole;
  return whole ? static_cast<int>(offset_of(whole, "x")) : 0;
}
