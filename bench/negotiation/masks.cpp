// Measures the costs for the publishing thread of 64 readers on another host, in one node or in two. The
// readers request different fields, or all of them the same fields. The costs are the duration of publish()
// for a large sample while no other sample is being sent, and the number of allocations.
#include <sft/sft.h>
#include <cstring>
#include <numeric>
#include <sensor_msgs/msg/PointCloud2.hpp>

#include "bench/common/cloud_masks.h"
#include "bench/common/contest.h"
#include "bench/common/hosts.h"
#include "bench/common/node_options.h"
#include "bench/common/shared.h"
#include "bench/common/statistics.h"
#include "bench/negotiation/negotiation.h"
#include "tests/support/process_allocations.h"

namespace sft::bench {

namespace {

using sensor_msgs::msg::PointCloud2;

constexpr std::size_t readers_asking = 64;
constexpr std::size_t data_bytes = 1'660'000;
constexpr std::size_t cache_bytes = 64 << 20;  // more than the size of any cache

/// A function that returns the fields that the reader with this number requests.
using Fields = std::string (*)(std::size_t);

std::string equal_fields_and_data(std::size_t) { return own_fields_and_data(readers_asking - 1); }
/// Returns the fields of a reader. Four readers, such as a display, a recorder and a planner, need the
/// data; 60 monitors do not.
std::string mostly_small_fields(std::size_t number) {
  return number < 4 ? own_fields_and_data(number) : "header.frame_id" + small_fields(number);
}

bool all_served(const PublisherStatus& status) {
  return status.readers.size() == readers_asking &&
         std::ranges::all_of(status.readers, &PublisherStatus::Reader::served);
}

/// Waits until each reader has the sample, or until no more samples arrive, since UDP may lose some.
void wait_for_readers(Exchange& exchange) {
  std::uint64_t before = 0;
  for (int quiet = 0; before < readers_asking && quiet < 100; ++quiet) {
    sleep_us(1000);
    const std::uint64_t received = exchange.received.load();
    if (received != before) quiet = 0;
    before = received;
  }
}

/// Clears the caches. Without this, one variant would have an advantage: the variants of 64 masks have so
/// many bytes that they clear the caches by themselves.
std::uint64_t clear_caches(const std::vector<std::uint64_t>& larger_than_caches) {
  return std::accumulate(larger_than_caches.begin(), larger_than_caches.end(), std::uint64_t{0});
}

/// Returns the time in microseconds of a copy of the data with cleared caches.
double copy_us(const PointCloud2& cloud, const std::vector<std::uint64_t>& rubbish,
               std::vector<std::uint8_t>& to) {
  if (clear_caches(rubbish) == 0) return 0;
  const std::int64_t begin = now_ns();
  std::memcpy(to.data(), cloud.data.data(), to.size());
  clobber_memory();
  return static_cast<double>(now_ns() - begin) / 1000;
}

/// The results of one round.
struct Costs {
  double allocations = 0;  ///< number of allocations per sample
  double copy_us = 0;      ///< the time of a memcpy of the data in microseconds
};

/// Publishes, and counts the allocations of a sample in all threads after buffers have grown. The median of
/// the second half is used, because some samples coincide with allocations that a node makes for its
/// heartbeats.
void publish(Exchange& exchange, std::uint64_t samples, bool asynchronous, Costs& costs) {
  Node node = Node::open(udp_node_options("publisher")).value();
  auto publisher = node.publisher<PointCloud2>("points", {.asynchronous = asynchronous}).value();
  PointCloud2 cloud;
  cloud.data.resize(data_bytes);
  const std::vector<std::uint64_t> rubbish(cache_bytes / sizeof(std::uint64_t), 1);
  while (!all_served(publisher.status())) sleep_us(1000);
  std::vector<std::uint8_t> copy(data_bytes);
  std::vector<double> steady, copies_us;
  steady.reserve(samples);
  copies_us.reserve(samples);
  for (std::uint64_t i = 0; i < samples && !exchange.failed.load(); ++i) {
    exchange.received = 0;
    copies_us.push_back(copy_us(cloud, rubbish, copy));
    exchange.failed = clear_caches(rubbish) == 0;
    sleep_us(2000);  // without a pause, the scheduler would give the core to the sending thread at once
    const std::uint64_t before = test::process_allocations();
    exchange.sent_at[i] = now_ns();
    publisher.publish(cloud);
    exchange.received_at[i] = now_ns();
    wait_for_readers(exchange);
    if (i >= samples / 2) steady.push_back(static_cast<double>(test::process_allocations() - before));
  }
  costs = {.allocations = median(steady), .copy_us = median(copies_us)};
  exchange.sent = 1;
}

/// Opens the readers, which are divided equally among the nodes. The publisher serves each node separately.
void subscribe(Exchange& exchange, Fields fields, std::size_t nodes_asking) {
  const auto count = [&](const DynamicSample&) { exchange.received.fetch_add(1); };
  std::vector<Node> nodes;
  std::vector<DynamicSubscriber> subscribers;
  for (std::size_t i = 0; i < readers_asking; ++i) {
    if (nodes.size() * readers_asking <= i * nodes_asking)
      nodes.push_back(Node::open(udp_node_options("subscriber")).value());
    const DynamicType type = nodes.back().find_type("points", std::chrono::seconds(5)).value();
    subscribers.push_back(nodes.back().subscriber("points", type, fields(i), {}, count).value());
  }
  while (exchange.sent.load() == 0 && !exchange.failed.load()) sleep_us(10'000);
}

struct Asking {
  Fields fields;
  std::uint64_t samples;
  bool asynchronous = false;
  std::size_t nodes = 1;  ///< the number of the readers' nodes
  Rounds times{};
  double allocations = 0;  ///< number of allocations per sample, in the worst round
  std::vector<double> copies_us{};

  void run(const TwoHosts& hosts) {
    const Shared<Costs> costs;
    const std::uint64_t n = samples;
    times.add(run_pair(hosts.sides([&, n](Exchange& e) { publish(e, n, asynchronous, *costs); },
                                   [this](Exchange& e) { subscribe(e, fields, nodes); }),
                       n));
    allocations = std::max(allocations, costs->allocations);
    copies_us.push_back(costs->copy_us);
  }
};

}  // namespace

std::vector<Figure> publish_64_masks(const Scale& scale) {
  const TwoHosts hosts;
  Asking one{equal_fields_and_data, 60}, handed_over{equal_fields_and_data, 60, true};
  Asking others_wait{equal_fields_and_data, 60, false, 2};
  Asking all{own_fields_and_data, 20}, most{mostly_small_fields, 60};
  for (int round = 0; round < scale.rounds; ++round) {
    for (Asking* asking : {&one, &handed_over, &others_wait, &all, &most}) asking->run(hosts);
  }
  const char* reference = "the same readers, one mask";
  return {{"publish_64_masks", all.times.p50(), "us", one.times.p50(), reference, 2},
          {"publish_64_one_mask", one.times.p50(), "us", median(one.copies_us), "memcpy of the data", 1.5},
          {"publish_64_asynchronous", handed_over.times.p50(), "us", median(handed_over.copies_us),
           "memcpy of the data", 1.5},
          {"publish_64_others_wait", others_wait.times.p50(), "us", median(others_wait.copies_us),
           "memcpy of the data", 1.5},
          {"publish_64_mixed", most.times.p50(), "us", one.times.p50(), reference, 2},
          {"publish_64_masks_allocations", all.allocations, "", {}, "per sample, in all threads", 0},
          {"publish_64_mixed_allocations", most.allocations, "", {}, "likewise", 0}};
}

}  // namespace sft::bench
