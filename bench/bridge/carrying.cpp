#include <fcntl.h>
#include <sft/sft.h>
#include <unistd.h>
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <std_msgs/msg/String.hpp>
#include <string>
#include <utility>
#include <vector>

#include "bench/bridge/bridge.h"
#include "bench/bridge/radio.h"
#include "bench/common/node_options.h"
#include "bench/common/pair.h"
#include "bench/common/shared.h"
#include "bench/common/statistics.h"
#include "bench/selection/messages.h"

namespace sft::bench {

namespace {

using namespace std::chrono_literals;
using sensor_msgs::msg::PointCloud2;
using std_msgs::msg::String;

constexpr double missing_bound = 1, p99_bound = 1.1;
constexpr std::int64_t cloud_period_ms = 100, small_period_ms = 50;
constexpr std::size_t small_bytes = 100;
constexpr std::size_t numbers_max = 20'000;
constexpr std::int64_t straggling_us = 2'000'000;  // the time to wait for late samples

/// The times of the samples of a topic, by their numbers from 1.
struct Times {
  std::atomic<std::uint32_t> sent{0};      ///< the number of the last sample that was sent
  std::atomic<std::uint32_t> received{0};  ///< the number of the last sample that arrived at the station
  std::atomic<std::int64_t> sent_at[numbers_max] = {};
  std::atomic<std::int64_t> local_at[numbers_max] = {};
  std::atomic<std::int64_t> remote_at[numbers_max] = {};

  void note_remote(std::uint32_t number) {
    if (number == 0 || number >= numbers_max) return;
    remote_at[number] = now_ns();
    received = number;
  }
};

struct Board {
  Times clouds, small;
  std::atomic<bool> has_local_reader{false};
};

NodeOptions options_in(std::uint32_t domain, const char* name, TransportChoice transport) {
  NodeOptions options = node_options(name, transport);
  options.domain = domain;
  options.vanilla_dds = NodeOptions::VanillaDds::never;
  return options;
}

/// Publishes clouds whose data are not written, because in a real driver the device would write them.
int send_clouds(Times& times) {
  Node node = Node::open(options_in(robot_domain, "lidar", TransportChoice::shm)).value();
  auto publisher = node.publisher<PointCloud2>("points").value();
  PointCloud2 prototype = ouster_cloud();
  const std::size_t bytes = prototype.data.size();
  prototype.data.clear();
  for (std::int64_t due = now_ns();; due += cloud_period_ms * 1'000'000) {
    sleep_until(due);
    const std::uint32_t number = times.sent + 1;
    if (number >= numbers_max) return 0;
    prototype.header.stamp.sec = static_cast<std::int32_t>(number);
    times.sent_at[number] = now_ns();
    auto loan = publisher.loan_for_overwrite(prototype, {.data = bytes});
    if (loan) std::move(*loan).publish();
    times.sent = number;
  }
}

int send_small(Times& times) {
  Node node = Node::open(options_in(robot_domain, "events", TransportChoice::shm)).value();
  auto publisher = node.publisher<String>("small", {.reliability = reliable}).value();
  for (std::int64_t due = now_ns();; due += small_period_ms * 1'000'000) {
    sleep_until(due);
    const std::uint32_t number = times.sent + 1;
    if (number >= numbers_max) return 0;
    String message{.data = std::to_string(number)};
    message.data.resize(small_bytes, ' ');
    times.sent_at[number] = now_ns();
    publisher.publish(message);
    times.sent = number;
  }
}

int read_clouds(Board& board) {
  Node node = Node::open(options_in(robot_domain, "detector", TransportChoice::shm)).value();
  const auto subscriber = node.subscriber<PointCloud2>("points", [&](const auto& sample) {
    const auto number = static_cast<std::size_t>(sample->header().stamp().sec());
    if (number < numbers_max) board.clouds.local_at[number] = now_ns();
    board.has_local_reader = true;
  });
  if (!subscriber) return 1;
  for (;;) pause();
}

int read_small(Times& times) {
  yield_to_robot();
  Node node = Node::open(options_in(station_domain, "display", TransportChoice::udp)).value();
  const auto subscriber = node.subscriber<String>(
      "small",
      [&](const auto& sample) {
        times.note_remote(static_cast<std::uint32_t>(std::atoi(std::string(sample->data()).c_str())));
      },
      {.reliability = reliable});
  if (!subscriber) return 1;
  for (;;) pause();
}

/// Reads records of vanilla_reader (tests/system/vanilla_reader.c) until it ends.
void note_clouds(int records, Times& times) {
  struct {
    std::int64_t stamp;
    std::uint32_t kind, bytes;
  } head{};
  constexpr std::uint32_t sample = 2;
  constexpr std::size_t encapsulation = 4;
  const auto read_all = [&](void* to, std::size_t bytes) {
    for (std::size_t done = 0; done < bytes;) {
      const ssize_t n = read(records, static_cast<char*>(to) + done, bytes - done);
      if (n <= 0) return false;
      done += static_cast<std::size_t>(n);
    }
    return true;
  };
  std::vector<char> body;
  while (read_all(&head, sizeof head)) {
    body.resize(head.bytes);
    if (!read_all(body.data(), body.size())) return;
    std::uint32_t number = 0;
    if (head.kind != sample || body.size() < encapsulation + sizeof number) continue;
    std::memcpy(&number, body.data() + encapsulation, sizeof number);
    times.note_remote(number);
  }
}

/// Runs the unmodified DDS reader, and notes the samples that it receives.
int read_clouds_by_dds(Times& times) {
  yield_to_robot();
  setenv("CYCLONEDDS_URI", "<Internal><SocketReceiveBufferSize min=\"default\" max=\"4MB\"/></>", 1);
  int ends[2];
  if (pipe(ends) != 0) return 1;
  const pid_t reader = fork();
  if (reader == 0) {
    dup2(ends[1], STDOUT_FILENO);
    close(ends[0]);
    _exit(execute("vanilla_reader",
                  {std::to_string(station_domain), "rt/points", "reliable", "volatile", "10", "plain"}));
  }
  close(ends[1]);
  note_clouds(ends[0], times);
  return 1;
}

/// The measurements of all rounds.
struct Found {
  std::vector<double> local_us{};  ///< times from publish() to the reader on the robot
  std::vector<double> small_ms{};  ///< times from publish() to the reader at the station
  double sent = 0, came = 0;       ///< the numbers of clouds that were sent and that arrived
};

/// The numbers of the samples that are sent during a measurement: [first, end).
struct Span {
  std::uint32_t first, end;
};

void add_local(const Times& times, Span span, std::vector<double>& us) {
  for (std::uint32_t i = span.first; i < span.end; ++i) {
    if (times.local_at[i] != 0) us.push_back(static_cast<double>(times.local_at[i] - times.sent_at[i]) / 1e3);
  }
}

void add_remote(const Board& board, Span clouds, Span small, Found& found) {
  for (std::uint32_t i = clouds.first; i < clouds.end; ++i) {
    ++found.sent;
    if (board.clouds.remote_at[i] != 0) ++found.came;
  }
  for (std::uint32_t i = small.first; i < small.end; ++i) {
    const std::int64_t at = board.small.remote_at[i];
    if (at != 0) found.small_ms.push_back(static_cast<double>(at - board.small.sent_at[i]) / 1e6);
  }
}

/// Measures for this time, in which nothing else is started.
std::pair<Span, Span> watch(const Board& board, double seconds) {
  const std::uint32_t clouds = board.clouds.sent + 1, small = board.small.sent + 1;
  sleep_us(static_cast<std::int64_t>(seconds * 1e6));
  return {{clouds, board.clouds.sent + 1}, {small, board.small.sent + 1}};
}

[[noreturn]] void fail_without_samples(const char* topic) {
  std::fprintf(stderr, "no sample of \"%s\" came to the station by the bridges within 20 s\n", topic);
  std::exit(1);
}

}  // namespace

std::vector<Figure> bridge_carrying(const BridgeScale& scale) {
  const Shared<Board> board;
  const Radio radio = make_radio();
  HostProcesses programs(radio, 1);
  programs.start(robot_host, [&] { return send_clouds(board->clouds); });
  programs.start(robot_host, [&] { return send_small(board->small); });
  programs.start(robot_host, [&] { return read_clouds(*board); });
  programs.start(station_host, [&] { return read_small(board->small); });
  programs.start(station_host, [&] { return read_clouds_by_dds(board->clouds); });
  wait_until([&] { return board->has_local_reader.load(); });
  Found alone, beside;
  for (int round = 0; round < scale.rounds; ++round) {
    add_local(board->clouds, watch(*board, scale.seconds).first, alone.local_us);
    const Bridges bridges(radio);
    const std::uint32_t clouds = board->clouds.sent, small = board->small.sent;
    if (!wait_until([&] { return board->clouds.received > clouds && board->small.received > small; }))
      fail_without_samples(board->clouds.received > clouds ? "small" : "points");
    const auto [of_clouds, of_small] = watch(*board, scale.seconds);
    sleep_us(straggling_us);
    add_local(board->clouds, of_clouds, beside.local_us);
    add_remote(*board, of_clouds, of_small, beside);
  }
  const double missing = beside.sent == 0 ? 100 : 100 * (1 - beside.came / beside.sent);
  return {{.name = "bridge_missing", .value = missing, .unit = "%", .bound = missing_bound},
          {.name = "bridge_local_p99",
           .value = quantile(beside.local_us, 0.99),
           .unit = "us",
           .reference = quantile(alone.local_us, 0.99),
           .reference_name = "without the bridge",
           .bound = p99_bound},
          {.name = "bridge_small_p99", .value = quantile(beside.small_ms, 0.99), .unit = "ms"}};
}

}  // namespace sft::bench
