// Measures the processor time of programs that send or receive point clouds of 6.3 MB at 10 Hz.
#include <sft/sft.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <set>
#include <utility>

#include "bench/common/hosts.h"
#include "bench/common/node_options.h"
#include "bench/common/statistics.h"
#include "bench/vanilla/plain.h"
#include "bench/vanilla/vanilla.h"

namespace sft::bench {

namespace {

using sensor_msgs::msg::PointCloud2;

constexpr double write_bound = 0.95, read_bound = 1.1;
constexpr std::int64_t joining_us = 500'000;
/// The maximum size of a sample. With this size, the publisher keeps two samples for resending.
constexpr std::size_t sample_bytes_max = 8 << 20;

NodeOptions serving_node(const char* name) {
  NodeOptions options = udp_node_options(name);
  options.vanilla_dds = NodeOptions::VanillaDds::always;
  return options;
}

using Write = std::function<void(std::uint32_t number)>;

/// Writes `samples` samples as soon as there is a reader.
void write_all(Exchange& exchange, std::uint64_t samples, const std::function<bool()>& has_reader,
               const Write& write) {
  exchange.failed = !wait_until(has_reader);
  sleep_us(joining_us);
  const std::int64_t begin = now_ns(), cpu_begin = process_cpu_ns();
  for (std::uint64_t i = 1; i <= samples && !exchange.failed; ++i) {
    sleep_until(begin + static_cast<std::int64_t>(i) * vanilla_period_ns);
    write(static_cast<std::uint32_t>(i));
  }
  sleep_until(now_ns() + vanilla_period_ns);  // waits until the last sample has been sent
  exchange.returned_at[0] = process_cpu_ns() - cpu_begin;
  exchange.sent = samples;
}

struct Serving {
  Node node = Node::open(serving_node("writer")).value();
  Publisher<PointCloud2> publisher =
      node.publisher<PointCloud2>("points", {.max_sample_bytes = sample_bytes_max}).value();
  bool has_reader() const { return publisher.status().vanilla_readers == 1; }
};

/// A driver has written the data into the struct.
void publish_structs(Exchange& exchange, std::uint64_t samples) {
  Serving serving;
  PointCloud2 cloud;
  cloud.data.resize(vanilla_cloud_bytes);
  write_all(
      exchange, samples, [&] { return serving.has_reader(); },
      [&](std::uint32_t number) {
        cloud.height = number;
        serving.publisher.publish(cloud);
      });
}

/// A driver has written the data into the sample itself.
void publish_loans(Exchange& exchange, std::uint64_t samples) {
  Serving serving;
  PointCloud2 prototype;
  write_all(
      exchange, samples, [&] { return serving.has_reader(); },
      [&](std::uint32_t number) {
        prototype.height = number;
        auto loan = serving.publisher.loan_for_overwrite(prototype, {.data = vanilla_cloud_bytes});
        std::move(loan).value().publish();
      });
}

void write_by_cyclone(Exchange& exchange, std::uint64_t samples) {
  PlainWriter writer(vanilla_cloud_bytes);
  write_all(
      exchange, samples, [&] { return writer.readers() == 1; },
      [&](std::uint32_t number) { writer.write(number); });
}

/// Opens a reader with `open`. Counts the samples that arrive at this reader, and measures the processor
/// time until all samples were sent.
void read_all(Exchange& exchange, const std::function<std::shared_ptr<void>(std::function<void()>)>& open) {
  std::atomic<std::int64_t> came{0}, cpu_begin{0};
  const auto reader = open([&] {
    if (came++ == 0) cpu_begin = process_cpu_ns();
  });
  // The pause between two checks is so long that they take hardly any processor time.
  while (exchange.sent == 0 && !exchange.failed) sleep_us(vanilla_period_ns / 1000);
  exchange.sent_at[0] = process_cpu_ns() - cpu_begin;
  exchange.received_at[0] = came - 1;  // the first sample arrived before the measurement
}

void read_by_sft(Exchange& exchange) {
  Node node = Node::open(serving_node("reader")).value();
  read_all(exchange, [&](std::function<void()> came) {
    return std::make_shared<Subscriber<PointCloud2>>(
        node.subscriber<PointCloud2>("points", [came = std::move(came)](const auto&) { came(); },
                                     {.reliability = reliable})
            .value());
  });
}

void read_by_cyclone(Exchange& exchange) {
  read_all(exchange, [](std::function<void()> came) {
    return std::make_shared<PlainReader>([came = std::move(came)](std::uint32_t) { came(); });
  });
}

/// The measurements of both sides of a pair.
struct Measured {
  double writing_ms = 0;  ///< processor time per written sample
  double reading_ms = 0;  ///< processor time per received sample
};

using Writes = void (*)(Exchange&, std::uint64_t samples);
using Reads = void (*)(Exchange&);

/// Measures a pair of programs. Returns nothing if at least a tenth of the samples are lost.
std::optional<Measured> measure(const TwoHosts& hosts, std::uint64_t samples, Writes write, Reads read) {
  const auto one = run_deliveries(hosts.sides([=](Exchange& e) { write(e, samples); }, read), 1);
  if (one.empty()) return {};
  const auto sent = static_cast<double>(samples), came = static_cast<double>(one[0].received_at);
  if (came < 0.9 * sent) return {};
  return Measured{.writing_ms = static_cast<double>(one[0].returned_at) / 1e6 / sent,
                  .reading_ms = static_cast<double>(one[0].sent_at) / 1e6 / came};
}

struct Pair {
  Writes write;
  Reads read;
};
constexpr Pair without_sft{write_by_cyclone, read_by_cyclone};
/// Returns the median of each pair. The pairs are measured in turns.
std::vector<double> compare(const VanillaScale& scale, const std::vector<Pair>& pairs,
                            double Measured::*cost) {
  const TwoHosts hosts;
  std::vector<std::vector<double>> costs(pairs.size());
  for (int round = 0; round < scale.rounds; ++round) {
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      if (const auto one = measure(hosts, scale.samples, pairs[i].write, pairs[i].read))
        costs[i].push_back((*one).*cost);
    }
  }
  std::vector<double> medians;
  for (const std::vector<double>& of_pair : costs) medians.push_back(median_if_any(of_pair));
  return medians;
}

/// Reads each message in two subscribers of one program. Both read it at the place in memory where it has
/// arrived.
void read_twice(Exchange& exchange) {
  Node node = Node::open(serving_node("reader")).value();
  auto first = node.subscriber<PointCloud2>("points", {.reliability = reliable}).value();
  auto second = node.subscriber<PointCloud2>("points", {.reliability = reliable}).value();
  const auto timeout = std::chrono::seconds(20);
  exchange.failed = !first.wait(timeout) || !second.wait(timeout);
  const auto one = first.take(), other = second.take();
  if (one && other) {
    const std::set<const void*> places{one->data().data(), other->data().data()};
    exchange.received_at[0] = static_cast<std::int64_t>(places.size());
  }
  wait_until([&] { return exchange.sent != 0; });
}

void write_to_two(Exchange& exchange, std::uint64_t samples) {
  PlainWriter writer(vanilla_cloud_bytes);
  write_all(
      exchange, samples, [&] { return writer.readers() == 2; },
      [&](std::uint32_t number) { writer.write(number); });
}

double copies() {
  const TwoHosts hosts;
  const auto one = run_deliveries(hosts.sides([](Exchange& e) { write_to_two(e, 3); }, read_twice), 1);
  return one.empty() ? std::numeric_limits<double>::quiet_NaN() : static_cast<double>(one[0].received_at);
}

}  // namespace

/// The data are not written anew: as a driver does so, it takes the same time in a struct and in a loan.
std::vector<Figure> vanilla_write(const VanillaScale& scale) {
  const std::vector<double> costs =
      compare(scale, {{publish_loans, read_by_cyclone}, {publish_structs, read_by_cyclone}, without_sft},
              &Measured::writing_ms);
  const char* reference = "dds_write, CPU of a sample";
  return {{"vanilla_write", costs[0], "ms", costs[2], reference, write_bound},
          {"vanilla_write_struct", costs[1], "ms", costs[2], reference, {}}};
}

std::vector<Figure> vanilla_read(const VanillaScale& scale) {
  const std::vector<double> costs =
      compare(scale, {{write_by_cyclone, read_by_sft}, without_sft}, &Measured::reading_ms);
  return {{"vanilla_read", costs[0], "ms", costs[1], "dds_take, CPU of a sample", read_bound},
          {"vanilla_read_copies", copies(), "", {}, "of a message for two subscribers", 1}};
}

}  // namespace sft::bench
