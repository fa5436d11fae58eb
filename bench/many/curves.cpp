// Measures the costs of a sample at several sizes of one dimension: readers, masks, fields or bytes.
#include <algorithm>
#include <fields.hpp>
#include <utility>

#include "bench/common/cloud_masks.h"
#include "bench/common/statistics.h"
#include "bench/many/curve.h"
#include "bench/many/many.h"
#include "bench/many/sample_costs.h"
#include "bench/negotiation/response.h"
#include "fields.h"

namespace sft::bench {

namespace {

constexpr std::size_t cloud_bytes = 16'000;
constexpr std::int64_t period_us = 20'000;
constexpr std::int64_t settled_us = 250'000;

const std::vector<Curve::Cost> costs_of_sample{
    {"bytes", "B"}, {"publisher_cpu", "us"}, {"subscriber_cpu", "us"}, {"latency", "us"}};

std::vector<double> values(const Costs& costs) {
  return {costs.bytes, costs.publisher_cpu_us, costs.subscriber_cpu_us, costs.latency_us};
}

/// One point of a curve. A phase of a case is the measurement of a point.
struct Point {
  Curve& curve;
  std::size_t size;
  std::size_t phase = 0;
};

void measure(const Case& of, const std::vector<Point>& points) {
  const std::vector<Costs> ours = SampleCosts(sft_member, of).wait();
  const std::vector<Costs> theirs = SampleCosts(cyclone_member, of).wait();
  for (const Point& point : points) {
    point.curve.add_ours(point.size, values(ours[point.phase]));
    point.curve.add_reference(point.size, values(theirs[point.phase]));
  }
}

/// Returns the fields of readers that take turns at `count` different masks.
Fields masks(std::size_t count) {
  return [=](std::size_t reader) { return own_fields_and_data(reader % count); };
}

Case readers_of_cloud(std::size_t readers, std::vector<Fields> phases, const ManyScale& scale) {
  const double few_s = scale.quick ? 0.35 : 1;
  return {.readers = readers,
          .hosts = std::min(readers, emulated_hosts),
          .topic = cloud_topic(cloud_bytes),
          .phases = std::move(phases),
          .settling_s = readers < 64 ? few_s : 2 * few_s,  // longer for many masks, whose groups form later
          .samples = scale.quick ? std::uint64_t{10} : 40,
          .period_us = period_us,
          .settled_us = settled_us};
}

Case one_reader(Topic topic, std::vector<Fields> phases, std::uint64_t samples) {
  return {.readers = 1,
          .hosts = 1,
          .topic = std::move(topic),
          .phases = std::move(phases),
          .settling_s = 0,
          .samples = samples,
          .period_us = period_us,
          .settled_us = settled_us,
          .warming = samples};  // the traffic of joining ends while these samples are sent
}

std::string first_field(std::size_t) { return "f0"; }

/// Returns the fields f0, f2, f4 and so on.
Fields every_other_of(std::size_t count) {
  return [=](std::size_t) {
    std::string text = "f0";
    for (std::size_t i = 2; i < count; i += 2) text += ", f" + std::to_string(i);
    return text;
  };
}

template <class Type>
struct SecondField {
  using Message = Type;
  static constexpr auto wanted = Message::Field::f1;
  static void read_usual(const auto& sample) { (void)sample->f0(); }
  static void read_wanted(const auto& sample) { (void)sample->f1(); }
};

struct FieldCurves {
  template <class Message>
  void measure_fields(std::size_t count, const dds_topic_descriptor_t& type, const ManyScale& scale) {
    measure(
        one_reader(zeros_topic<Message>(type), {first_field, every_other_of(count)}, scale.quick ? 10 : 40),
        {{one, count}, {half, count, 1}});
    const TwoHosts hosts;
    const std::uint64_t requests = scale.quick ? 30 : 200;
    response.add_ours(count, {median_if_any(response_times<SecondField<Message>>(hosts, requests))});
    response.add_reference(count, {median_if_any(dds_write_times(hosts, requests))});
  }
  void measure_all(const ManyScale& scale) {
    using namespace sft_bench::growth;
    measure_fields<Fields8>(8, sft_bench_growth_Fields8_desc, scale);
    measure_fields<Fields32>(32, sft_bench_growth_Fields32_desc, scale);
    measure_fields<Fields128>(128, sft_bench_growth_Fields128_desc, scale);
    measure_fields<Fields512>(512, sft_bench_growth_Fields512_desc, scale);
  }

  static inline const std::vector<std::size_t> counts{8, 32, 128, 512};
  Curve one{"growth_fields", counts, costs_of_sample}, half{"growth_fields_half", counts, costs_of_sample},
      response{"growth_fields", counts, {{"response", "us"}}, "dds_write to a listener"};
};

std::vector<Figure> report_of(const std::vector<Curve>& curves) {
  std::vector<Figure> all;
  for (const Curve& curve : curves) {
    const std::vector<Figure> figures = curve.report();
    all.insert(all.end(), figures.begin(), figures.end());
  }
  return all;
}

}  // namespace

/// 64 nodes take seconds to find each other. So the same nodes are used for all masks, and change their
/// requests.
std::vector<Figure> readers(const ManyScale& scale) {
  const std::vector<std::size_t> counts{1, 4, 16, 64};
  Curve of_readers("growth_readers", counts, costs_of_sample);
  Curve of_masks("growth_masks", counts, costs_of_sample);
  for (int round = 0; round < scale.rounds; ++round) {
    for (const std::size_t few : {1, 4, 16})
      measure(readers_of_cloud(few, {masks(1)}, scale), {{of_readers, few}});
    const Case all = readers_of_cloud(64, {masks(1), masks(4), masks(16), masks(64)}, scale);
    measure(all, {{of_readers, 64}, {of_masks, 1}, {of_masks, 4, 1}, {of_masks, 16, 2}, {of_masks, 64, 3}});
  }
  return report_of({of_readers, of_masks});
}

std::vector<Figure> fields(const ManyScale& scale) {
  FieldCurves curves;
  for (int round = 0; round < scale.rounds; ++round) curves.measure_all(scale);
  return report_of({curves.one, curves.half, curves.response});
}

std::vector<Figure> sizes(const ManyScale& scale) {
  struct Size {
    std::size_t bytes;
    std::uint64_t samples, quick_samples;
  };
  const Size sizes[] = {{64, 40, 10}, {4 << 10, 40, 10}, {1 << 20, 40, 10}, {32 << 20, 8, 3}};
  Curve curve("growth_sizes", {64, 4 << 10, 1 << 20, 32 << 20}, costs_of_sample);
  for (int round = 0; round < scale.rounds; ++round) {
    for (const auto& [bytes, samples, quick_samples] : sizes)
      measure(one_reader(bulk_topic(bytes), {[](std::size_t) { return "*"; }},
                         scale.quick ? quick_samples : samples),
              {{curve, bytes}});
  }
  return curve.report();
}

}  // namespace sft::bench
