// Measures what vanilla readers of a topic cost its other readers. Two figures are measured: the latency
// within the host of the publisher while a vanilla reader is stopped, and the bytes that another host
// receives.
#include <sft/sft.h>

#include <atomic>
#include <csignal>
#include <cstdlib>
#include <memory>
#include <sensor_msgs/msg/PointCloud2.hpp>

#include "bench/common/host_processes.h"
#include "bench/common/hosts.h"
#include "bench/common/node_options.h"
#include "bench/common/shared.h"
#include "bench/common/statistics.h"
#include "bench/vanilla/plain.h"
#include "bench/vanilla/vanilla.h"

namespace sft::bench {

namespace {

using sensor_msgs::msg::PointCloud2;

constexpr double latency_bound = 1.1, bytes_bound = 1.005;
/// The factor by which the number of samples is increased, because a p99 needs more samples.
constexpr std::uint64_t for_p99 = 3;
constexpr std::int64_t quiet_us = 1'000'000;

NodeOptions node_of(const char* name, TransportChoice transport) {
  NodeOptions options = node_options(name, transport);
  options.vanilla_dds = NodeOptions::VanillaDds::always;
  return options;
}

int read_until_killed() {
  const PlainReader reader([](std::uint32_t) {});
  for (;;) sleep_us(quiet_us);
}

int read_until_matched_and_stop() {
  const PlainReader reader([](std::uint32_t) {});
  if (!wait_until([&] { return reader.writers() == 1; })) return 1;
  sleep_us(quiet_us);  // waits until the writer knows the reader, too
  raise(SIGSTOP);
  return 0;
}

void publish_locally(Exchange& exchange, std::uint64_t samples, std::size_t vanilla_readers) {
  Node node = Node::open(node_of("publisher", TransportChoice::shm)).value();
  auto publisher = node.publisher<PointCloud2>("points").value();
  exchange.failed = !wait_until([&] {
    const PublisherStatus status = publisher.status();
    return status.vanilla_readers == vanilla_readers && status.readers.size() == 1 &&
           status.readers[0].served;
  });
  sleep_us(quiet_us);
  PointCloud2 cloud;
  cloud.data.resize(vanilla_cloud_bytes);
  const std::int64_t begin = now_ns();
  for (std::uint64_t i = 0; i < samples && !exchange.failed; ++i) {
    sleep_until(begin + static_cast<std::int64_t>(i) * vanilla_period_ns);
    cloud.height = static_cast<std::uint32_t>(i + 1);
    exchange.sent_at[i] = now_ns();
    publisher.publish(cloud);
  }
  wait_until([&] { return exchange.received == samples; }, 1);
  exchange.sent = samples;
}

void subscribe_locally(Exchange& exchange) {
  Node node = Node::open(node_of("subscriber", TransportChoice::shm)).value();
  const auto subscriber = node.subscriber<PointCloud2>("points",
                                                       [&](const auto& sample) {
                                                         const std::uint64_t number = sample->height();
                                                         exchange.note_receipt(number);
                                                       })
                              .value();
  wait_until([&] { return exchange.sent != 0 || exchange.failed; }, 200);
}

std::vector<double> local_times(std::shared_ptr<const hosts::EmulatedNetwork> network, std::uint64_t samples,
                                bool beside_stopped_reader) {
  HostProcesses others(network, 1);
  if (beside_stopped_reader) others.start(1, read_until_matched_and_stop);
  const std::size_t vanilla_readers = beside_stopped_reader ? 1 : 0;
  const auto enter = [&] {
    if (!network->host(0).enter()) std::abort();
  };
  return run_pair({.sender = [=](Exchange& e) { publish_locally(e, samples, vanilla_readers); },
                   .receiver = subscribe_locally,
                   .enter_sender = enter,
                   .enter_receiver = enter},
                  samples);
}

/// The values that the publisher and its parent process exchange.
struct Board {
  std::atomic<bool> is_served{false};
  std::atomic<std::size_t> vanilla_readers{0};
  /// Numbers of samples: up to which the publisher must publish, and up to which it has published
  std::atomic<std::uint64_t> wanted{0}, published{0};
};

int publish_what_is_wanted(Board& board) {
  Node node = Node::open(node_of("publisher", TransportChoice::udp)).value();
  auto publisher = node.publisher<PointCloud2>("points").value();
  PointCloud2 cloud;
  cloud.height = 1;
  cloud.point_step = 16;
  cloud.row_step = vanilla_cloud_bytes;
  cloud.width = cloud.row_step / cloud.point_step;
  cloud.data.resize(vanilla_cloud_bytes);
  for (;;) {
    const PublisherStatus status = publisher.status();
    board.is_served = status.readers.size() == 1 && status.readers[0].served;
    board.vanilla_readers = status.vanilla_readers;
    sleep_us(vanilla_period_ns / 1000);
    if (board.published == board.wanted) continue;
    publisher.publish(cloud);
    ++board.published;
  }
}

/// Subscribes to every fourth point.
int subscribe_until_killed() {
  Node node = Node::open(node_of("subscriber", TransportChoice::udp)).value();
  const auto subscriber =
      node.subscriber<PointCloud2>("points", [](const auto&) {}, {.selection = "data[::4]"}).value();
  for (;;) sleep_us(quiet_us);
}

/// Returns the bytes that host 1 receives per sample.
double bytes_of_each_sample(const HostProcesses& processes, Board& board, std::uint64_t samples) {
  sleep_us(quiet_us);
  const LinkBytes before = processes.link_bytes(1);
  board.wanted += samples;
  wait_until([&] { return board.published == board.wanted; }, 200);
  sleep_us(quiet_us);
  const LinkBytes after = processes.link_bytes(1);
  return static_cast<double>(after.received - before.received) / static_cast<double>(samples);
}

}  // namespace

std::vector<Figure> local_beside_stopped_vanilla(const VanillaScale& scale) {
  const auto network = std::make_shared<const hosts::EmulatedNetwork>(make_hosts(2, Trains::cut));
  Rounds beside, alone;
  for (int round = 0; round < scale.rounds; ++round) {
    beside.add(local_times(network, for_p99 * scale.samples, true));
    alone.add(local_times(network, for_p99 * scale.samples, false));
  }
  const char* reference = "without a vanilla reader";
  return {{"local_p99_stopped_vanilla", beside.p99(), "us", alone.p99(), reference, latency_bound},
          {"local_p50_stopped_vanilla", beside.p50(), "us", alone.p50(), reference, {}}};
}

std::vector<Figure> bytes_to_sft_readers(const VanillaScale& scale) {
  HostProcesses processes(2);
  const Shared<Board> board;
  processes.start(0, [&] { return publish_what_is_wanted(*board); });
  processes.start(1, subscribe_until_killed);
  if (!wait_until([&] { return board->is_served.load(); })) return {};
  const double before = bytes_of_each_sample(processes, *board, scale.samples);
  processes.start(2, read_until_killed);
  if (!wait_until([&] { return board->vanilla_readers == 1; })) return {};
  const double after = bytes_of_each_sample(processes, *board, scale.samples);
  return {{"bytes_to_sft_readers", after, "B", before, "before a vanilla reader came", bytes_bound}};
}

}  // namespace sft::bench
