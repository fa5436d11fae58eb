// Measures how costs grow with the number of nodes, each of which has ten endpoints. The nodes form a ring:
// each one subscribes to the five topics of the next one, which runs on another host. So the number of
// matching pairs grows only as fast as the number of nodes. Node 0 has a host to itself. All other nodes
// are in up to eight processes on as many hosts.
#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bench/common/host_processes.h"
#include "bench/common/pair.h"
#include "bench/common/shared.h"
#include "bench/many/curve.h"
#include "bench/many/many.h"
#include "bench/many/members.h"

namespace sft::bench {

namespace {

constexpr std::size_t topics = 5;  // number of topics that each node publishes, and to which it subscribes
constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

/// `all_s` is the time limit of a contender for all sizes together. Nodes are idle for `settled_s` before
/// they are observed for `window_s`.
struct Times {
  double all_s, settled_s, window_s;
};

std::string topic_name(std::size_t node, std::size_t topic) { return fmt::format("ring_{}_{}", node, topic); }

/// A node with a participant, writers and readers of its own.
class RingNode {
 public:
  RingNode(const Member& member, std::size_t number, std::size_t next) : peer_(member.open()) {
    Topic topic = cloud_topic(0);
    for (std::size_t i = 0; i < topics; ++i) {
      topic.name = topic_name(number, i);
      writers_.push_back(peer_->writer(topic));
      topic.name = topic_name(next, i);
      readers_.push_back(peer_->reader(topic));
    }
  }
  bool matched() const {
    return hears_all() && std::ranges::all_of(writers_, [](const auto& writer) { return writer->serves(1); });
  }
  /// Returns true if each topic to which the node subscribes has a publisher.
  bool hears_all() const {
    return std::ranges::all_of(readers_, [](const auto& reader) { return reader->writers() == 1; });
  }

 private:
  const std::unique_ptr<Peer> peer_;
  std::vector<std::unique_ptr<Writer>> writers_;
  std::vector<std::unique_ptr<Reader>> readers_;
};

struct Board {
  std::atomic<std::size_t> matched{0};
  std::atomic<std::int64_t> last_ns{0};
  /// Time when the newcomer knew a publisher of each of its topics.
  std::atomic<std::int64_t> newcomer_ns{0};
};

/// Raises the limit of descriptors, because many nodes in a process have many sockets.
void allow_descriptors() {
  rlimit limit{};
  getrlimit(RLIMIT_NOFILE, &limit);
  limit.rlim_cur = limit.rlim_max;
  setrlimit(RLIMIT_NOFILE, &limit);
}

/// Returns the numbers of the nodes on a host.
std::vector<std::size_t> nodes_of(std::size_t host, std::size_t nodes) {
  std::vector<std::size_t> numbers;
  if (host == 0) numbers.push_back(0);
  for (std::size_t i = host; host > 0 && i < nodes; i += emulated_hosts) numbers.push_back(i);
  return numbers;
}

/// Returns the pause between two checks whether a node is matched. A longer pause would distort the time of
/// few nodes, and a shorter one the processor time of many nodes.
std::int64_t pause_us(std::size_t nodes) { return nodes > 32 ? 50'000 : 5'000; }

int be_some_nodes(const Member& member, Board& board, const std::vector<std::size_t>& numbers,
                  std::size_t nodes) {
  allow_descriptors();
  std::vector<std::unique_ptr<RingNode>> opened;
  for (const std::size_t number : numbers)
    opened.push_back(std::make_unique<RingNode>(member, number, (number + 1) % nodes));
  for (const auto& node : opened) {
    while (!node->matched()) sleep_us(pause_us(nodes));
    board.last_ns = now_ns();
    ++board.matched;
  }
  for (;;) pause();
}

/// Runs one more node in a separate process. The node subscribes to the topics of node 0.
int be_a_newcomer(const Member& member, Board& board, std::size_t nodes) {
  const RingNode node(member, nodes, 0);
  while (!node.hears_all()) sleep_us(1000);
  board.newcomer_ns = now_ns();
  for (;;) pause();
}

double megabytes(const LinkBytes& bytes) { return static_cast<double>(bytes.sent) / 1e6; }

/// Nodes that start together, and keep running.
class Ring {
 public:
  Ring(const Member& member, std::size_t nodes)
      : member_(member), nodes_(nodes), processes_(std::min(emulated_hosts, nodes - 1)), begin_ns_(now_ns()) {
    for (std::size_t host = 0; host < processes_.hosts(); ++host)
      processes_.start(host,
                       [&, host] { return be_some_nodes(member, *board_, nodes_of(host, nodes), nodes); });
  }

  /// Returns the costs of joining; nothing if not all nodes are matched in time.
  std::optional<std::vector<double>> join(double timeout_s) const {
    if (wait_until([&] { return board_->matched == nodes_; }, timeout_s))
      return std::vector{static_cast<double>(board_->last_ns - begin_ns_) / 1e9,
                         megabytes(processes_.link_bytes()), processes_.cpu_s()};
    fmt::print(stderr,
               "{}: {} of {} nodes were matched after {:.0f} s, {:.1f} MB and {:.1f} s of processor "
               "time\n",
               member_.name, board_->matched.load(), nodes_, timeout_s, megabytes(processes_.link_bytes()),
               processes_.cpu_s());
    return std::nullopt;
  }
  /// Returns the time from the start of one more process until its node knows a publisher of each of its
  /// topics.
  double newcomer_s(double timeout_s) {
    const std::int64_t begin_ns = now_ns();
    processes_.start(1, [&] { return be_a_newcomer(member_, *board_, nodes_); });
    if (!wait_until([&] { return board_->newcomer_ns != 0; }, timeout_s)) return unknown;
    return static_cast<double>(board_->newcomer_ns - begin_ns) / 1e9;
  }
  const HostProcesses& processes() const { return processes_; }

 private:
  const Member member_;
  const std::size_t nodes_;
  const Shared<Board> board_;
  HostProcesses processes_;
  const std::int64_t begin_ns_;
};

/// Returns the bytes per second that node 0 of the ring receives.
double received_per_s(const Ring& ring, double seconds) {
  const std::int64_t begin_ns = now_ns(), before = ring.processes().link_bytes(0).received;
  sleep_us(static_cast<std::int64_t>(seconds * 1e6));
  const std::int64_t bytes = ring.processes().link_bytes(0).received - before;
  return static_cast<double>(bytes) * 1e9 / static_cast<double>(now_ns() - begin_ns);
}

using Add = void (Curve::*)(std::size_t size, const std::vector<double>& values);

/// Adds the costs at each size, up to the first size at which this machine fails.
void measure_alone(const Member& member, Curve& curve, const std::vector<std::size_t>& sizes,
                   const Times& times, Add add) {
  const std::int64_t begin_ns = now_ns();
  for (const std::size_t nodes : sizes) {
    const double left_s = times.all_s - static_cast<double>(now_ns() - begin_ns) / 1e9;
    Ring ring(member, nodes);
    auto costs = ring.join(std::max(0., left_s - times.settled_s - times.window_s));
    if (!costs) {
      fmt::print(stderr, "{}: more nodes are not tried\n", member.name);
      return;
    }
    sleep_us(static_cast<std::int64_t>(times.settled_s * 1e6));
    costs->push_back(received_per_s(ring, times.window_s));
    costs->push_back(ring.newcomer_s(times.window_s));
    (curve.*add)(nodes, *costs);
  }
}

}  // namespace

std::vector<Figure> growth(const ManyScale& scale) {
  const std::vector<std::size_t> sizes =
      scale.quick ? std::vector<std::size_t>{12, 25, 50} : std::vector<std::size_t>{25, 50, 100, 200};
  const Times times = scale.quick ? Times{60, 3, 5} : Times{150, 10, 10};
  Curve curve("growth", sizes,
              {{"time", "s"}, {"bytes", "MB"}, {"cpu", "s"}, {"idle", "B/s"}, {"newcomer", "s"}});
  measure_alone(sft_member, curve, sizes, times, &Curve::add_ours);
  measure_alone(cyclone_member, curve, sizes, times, &Curve::add_reference);
  return curve.report();
}

}  // namespace sft::bench
