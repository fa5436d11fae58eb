// Measures how costs grow with the number of nodes, each of which has ten endpoints. Nodes form a ring: each
// one subscribes to the five topics of the next one, which runs on another host, so that the number of pairs
// that match grows no faster than the number of nodes. Node 0 has a host to itself; all others are in eight
// processes on as many hosts.
#include <fmt/format.h>
#include <sft/sft.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <string>
#include <utility>
#include <vector>

#include "bench/common/crowd.h"
#include "bench/common/cyclone.h"
#include "bench/common/cyclone_point_cloud.h"
#include "bench/common/pair.h"
#include "bench/common/shared.h"
#include "bench/many/exponent.h"
#include "bench/many/many.h"

namespace sft::bench {

namespace {

constexpr std::size_t topics = 5;          // that each node publishes, and as many it subscribes to
constexpr std::int64_t pause_us = 50'000;  // less would be seen in the processor time
constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

/// The time that a contender may take for all sizes, and the part of it in which idle nodes are watched at
/// each size. Both contenders together end within five minutes.
struct Times {
  double all_s, calm_s, window_s;
};

std::string topic_name(std::size_t node, std::size_t topic) { return fmt::format("ring_{}_{}", node, topic); }

class SftNode {
  using Message = sensor_msgs::msg::PointCloud2;

 public:
  static constexpr const char* name = "SFT";

  SftNode(std::size_t number, std::size_t next, bool) {
    for (std::size_t i = 0; i < topics; ++i) {
      publishers_.push_back(node_.publisher<Message>(topic_name(number, i)).value());
      subscribers_.push_back(node_.subscriber<Message>(topic_name(next, i)).value());
    }
  }
  bool matched() const {
    return std::ranges::all_of(publishers_,
                               [](const Publisher<Message>& publisher) {
                                 return publisher.wait_for_subscribers(1, std::chrono::nanoseconds(0));
                               }) &&
           std::ranges::all_of(subscribers_, [](const Subscriber<Message>& subscriber) {
             return std::ranges::any_of(subscriber.status().writers, &SubscriberStatus::Writer::connected);
           });
  }

 private:
  Node node_ = Node::open({.name = "member", .transport = TransportChoice::udp}).value();
  std::vector<Publisher<Message>> publishers_;
  std::vector<Subscriber<Message>> subscribers_;
};

class CycloneNode {
 public:
  static constexpr const char* name = "Cyclone DDS";

  CycloneNode(std::size_t number, std::size_t next, bool is_first_of_process)
      : participant_(is_first_of_process ? CycloneParticipant("") : CycloneParticipant()) {
    const auto& type = sensor_msgs_msg_PointCloud2_desc;
    const CycloneQos qos = cyclone_best_effort();
    for (std::size_t i = 0; i < topics; ++i) {
      writers_.push_back(participant_.writer(type, topic_name(number, i).c_str(), qos.get()));
      readers_.push_back(participant_.reader(type, topic_name(next, i).c_str(), qos.get(), nullptr, nullptr));
    }
  }
  bool matched() const {
    return std::ranges::all_of(writers_,
                               [](auto writer) { return CycloneParticipant::readers(writer) == 1; }) &&
           std::ranges::all_of(readers_,
                               [](auto reader) { return CycloneParticipant::writers(reader) == 1; });
  }

 private:
  const CycloneParticipant participant_;
  std::vector<dds_entity_t> writers_, readers_;
};

struct Board {
  std::atomic<std::size_t> matched{0};
  std::atomic<std::int64_t> last_ns{0};
};

/// Many nodes in a process have many sockets.
void allow_descriptors() {
  rlimit limit{};
  getrlimit(RLIMIT_NOFILE, &limit);
  limit.rlim_cur = limit.rlim_max;
  setrlimit(RLIMIT_NOFILE, &limit);
}

/// The numbers of the nodes of a host.
std::vector<std::size_t> nodes_of(std::size_t host, std::size_t nodes) {
  std::vector<std::size_t> numbers;
  if (host == 0) numbers.push_back(0);
  for (std::size_t i = host; host > 0 && i < nodes; i += crowd_hosts) numbers.push_back(i);
  return numbers;
}

template <class RingNode>
int be_some_nodes(Board& board, const std::vector<std::size_t>& numbers, std::size_t nodes) {
  allow_descriptors();
  std::vector<std::unique_ptr<RingNode>> opened;
  for (const std::size_t number : numbers)
    opened.push_back(std::make_unique<RingNode>(number, (number + 1) % nodes, opened.empty()));
  for (const auto& node : opened) {
    while (!node->matched()) sleep_us(pause_us);
    board.last_ns = now_ns();
    ++board.matched;
  }
  for (;;) pause();
}

struct Costs {
  double time_s = unknown, megabytes = unknown, cpu_s = unknown, idle_received = unknown;
};

double received_per_s(const Crowd& crowd, double seconds) {
  const std::int64_t before = crowd.link_bytes(0).received;
  const std::int64_t begin_ns = now_ns();
  sleep_us(static_cast<std::int64_t>(seconds * 1e6));
  return static_cast<double>(crowd.link_bytes(0).received - before) * 1e9 /
         static_cast<double>(now_ns() - begin_ns);
}

/// Nothing if not all are matched in time.
template <class RingNode>
std::optional<Costs> costs(std::size_t nodes, const Times& times, double joining_s) {
  const Shared<Board> board;
  Crowd crowd(crowd_hosts);
  const std::int64_t begin_ns = now_ns();
  for (std::size_t host = 0; host <= crowd_hosts; ++host)
    crowd.start(host, [&, host] { return be_some_nodes<RingNode>(*board, nodes_of(host, nodes), nodes); });
  if (!wait_until([&] { return board->matched == nodes; }, joining_s)) {
    fmt::print(
        stderr,
        "{}: {} of {} nodes were matched after {:.0f} s, {:.1f} MB and {:.1f} s of processor time; more "
        "nodes are not tried\n",
        RingNode::name, board->matched.load(), nodes, joining_s,
        static_cast<double>(crowd.link_bytes().sent) / 1e6, crowd.cpu_s());
    return std::nullopt;
  }
  Costs costs{.time_s = static_cast<double>(board->last_ns - begin_ns) / 1e9,
              .megabytes = static_cast<double>(crowd.link_bytes().sent) / 1e6,
              .cpu_s = crowd.cpu_s()};
  sleep_us(static_cast<std::int64_t>(times.calm_s * 1e6));
  costs.idle_received = received_per_s(crowd, times.window_s);
  return costs;
}

/// The costs at each size, up to the first one that this machine does not carry.
template <class RingNode>
std::vector<Costs> costs_of_all(const std::vector<std::size_t>& sizes, const Times& times) {
  std::vector<Costs> all;
  const std::int64_t begin_ns = now_ns();
  for (const std::size_t nodes : sizes) {
    const double left_s = times.all_s - static_cast<double>(now_ns() - begin_ns) / 1e9;
    const auto at_size = costs<RingNode>(nodes, times, std::max(0., left_s - times.calm_s - times.window_s));
    if (!at_size) break;
    all.push_back(*at_size);
  }
  all.resize(sizes.size());
  return all;
}

struct Column {
  const char* name;
  const char* unit;
  double Costs::*cost;
};
constexpr std::array columns{Column{"time", "s", &Costs::time_s}, Column{"bytes", "MB", &Costs::megabytes},
                             Column{"cpu", "s", &Costs::cpu_s}, Column{"idle", "B/s", &Costs::idle_received}};

/// Uses the sizes that both contenders have carried, so that both exponents are of the same range.
double exponent_of(const std::vector<Costs>& costs, const std::vector<Costs>& others,
                   const std::vector<std::size_t>& sizes, double Costs::*cost) {
  std::vector<std::pair<double, double>> pairs;
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    if (std::isfinite(others[i].*cost)) pairs.emplace_back(static_cast<double>(sizes[i]), costs[i].*cost);
  }
  return exponent(pairs);
}

}  // namespace

std::vector<Figure> growth(const ManyScale& scale) {
  const std::vector<std::size_t> sizes =
      scale.quick ? std::vector<std::size_t>{12, 25, 50} : std::vector<std::size_t>{25, 50, 100, 200};
  const Times times = scale.quick ? Times{60, 3, 5} : Times{150, 10, 10};
  const std::vector<Costs> ours = costs_of_all<SftNode>(sizes, times);
  const std::vector<Costs> theirs = costs_of_all<CycloneNode>(sizes, times);
  std::vector<Figure> figures;
  for (const Column& column : columns) {
    for (std::size_t i = 0; i < sizes.size(); ++i)
      figures.push_back({fmt::format("growth_{}_{}", sizes[i], column.name), ours[i].*column.cost,
                         column.unit, theirs[i].*column.cost, CycloneNode::name});
    figures.push_back({fmt::format("growth_exponent_{}", column.name),
                       exponent_of(ours, theirs, sizes, column.cost), "",
                       exponent_of(theirs, ours, sizes, column.cost), "that of Cyclone DDS"});
  }
  return figures;
}

}  // namespace sft::bench
