#include <sft/sft.h>
#include <sys/prctl.h>

#include <atomic>
#include <cstdint>
#include <mutex>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "bench/common/hosts.h"
#include "bench/common/node_options.h"
#include "bench/common/statistics.h"
#include "bench/negotiation/response.h"
#include "bench/selection/selection.h"

namespace sft::bench {

namespace {

using sensor_msgs::msg::PointCloud2;

constexpr std::uint32_t points = 4000;
constexpr std::uint32_t window_points = 16;

std::string window(std::uint64_t begin) {
  return "data[" + std::to_string(begin) + ":" + std::to_string(begin + window_points) + "]";
}

std::uint32_t begin_of_move(std::uint64_t n) {
  return static_cast<std::uint32_t>(n + 1) % (points - window_points);
}

PointCloud2 one_row() {
  PointCloud2 row;
  row.height = 1;
  row.width = row.row_step = points;
  row.point_step = 1;
  row.data.resize(points);
  return row;
}

/// The time at which the publisher sends the next row after a move of a window.
enum class Publishing : std::uint8_t {
  at_once,  ///< as soon as the window is in force, like a map server
  paced,    ///< some 60 us after the previous row, like a very fast sensor
};

/// Publishes rows, and notes when the publisher has each window in force. A paced publisher sends often, so
/// that the first row with a new window follows soon. If it sent more often, it would take the core from
/// the thread that puts the window in force. The default slack of timers would make each pause 50 us
/// longer.
void publish_rows(Exchange& exchange, std::uint64_t moves, Publishing publishing) {
  ::prctl(PR_SET_TIMERSLACK, 1UL);
  const PointCloud2 row = one_row();
  std::atomic<Publisher<PointCloud2>*> at_once{nullptr};
  // Needed because two threads publish here, and publish() is for one thread at a time.
  std::mutex publishing_mutex;
  const auto publish_one = [&](Publisher<PointCloud2>& publisher) {
    const std::scoped_lock lock(publishing_mutex);
    publisher.publish(row);
  };
  const auto note = [&](const PublisherStatus& status) {
    const std::uint64_t n = exchange.received.load();
    if (status.readers.empty() || n >= moves) return;
    const auto parts = status.readers[0].selection.parts();
    if (parts.empty() || parts[0].columns.begin != begin_of_move(n)) return;
    exchange.returned_at[n] = now_ns();
    if (auto* const publisher = at_once.load()) publish_one(*publisher);
  };
  Node node = Node::open(udp_node_options("publisher")).value();
  auto publisher = node.publisher<PointCloud2>("points", {.on_readers_changed = note}).value();
  if (publishing == Publishing::at_once) at_once = &publisher;
  while (exchange.received.load() < moves && !exchange.failed.load()) {
    if (publishing == Publishing::paced || exchange.received.load() == 0) publish_one(publisher);
    sleep_us(publishing == Publishing::paced ? 50 : 1000);
  }
  at_once = nullptr;
}

void move_window(Exchange& exchange, std::uint64_t moves) {
  Node node = Node::open(udp_node_options("subscriber")).value();
  const DynamicType type = node.find_type("points", std::chrono::seconds(20)).value();
  auto subscriber =
      node.subscriber("points", type, window(0), {.spin = std::chrono::milliseconds(1)}).value();
  for (std::uint64_t n = 0; n < moves && !exchange.failed.load(); ++n) {
    const std::uint32_t begin = begin_of_move(n);
    sleep_us(1000);
    while (subscriber.take()) continue;
    exchange.sent_at[n] = now_ns();
    exchange.failed = !subscriber.set_selection(window(begin));
    for (bool has_come = false; !has_come && !exchange.failed.load();) {
      exchange.failed = !subscriber.wait(std::chrono::seconds(2));
      while (const DynamicSample sample = subscriber.take())
        has_come = has_come || sample.selection()->parts()[0].columns.begin == begin;
    }
    exchange.received_at[n] = now_ns();
    exchange.received = n + 1;
  }
}

}  // namespace

std::vector<Figure> moved_windows(std::uint64_t moves, int rounds) {
  const TwoHosts hosts;
  Rounds whole_us, in_force_us, paced_us, response_us;
  for (int round = 0; round < rounds; ++round) {
    for (const Publishing publishing : {Publishing::at_once, Publishing::paced}) {
      const std::vector<Delivery> all =
          run_deliveries(hosts.sides([=](Exchange& e) { publish_rows(e, moves, publishing); },
                                     [=](Exchange& e) { move_window(e, moves); }),
                         moves);
      std::vector<double> whole, in_force;
      for (const Delivery& move : std::span(all).subspan(all.size() / 10)) {
        whole.push_back(move.us());
        if (move.returned_at != 0)
          in_force.push_back(static_cast<double>(move.returned_at - move.sent_at) / 1000.0);
      }
      const bool at_once = publishing == Publishing::at_once;
      (at_once ? whole_us : paced_us).add(std::move(whole));
      if (at_once) in_force_us.add(std::move(in_force));
    }
    response_us.add(response_times(hosts, moves));
  }
  return {{"window_move", whole_us.p50(), "us", response_us.p50(), "str_response", 1.3},
          {"window_in_force", in_force_us.p50(), "us", response_us.p50(), "str_response"},
          {"window_move_paced", paced_us.p50(), "us", response_us.p50(), "str_response"}};
}

}  // namespace sft::bench
