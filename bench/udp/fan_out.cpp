#include <sft/sft.h>
#include <algorithm>
#include <csignal>
#include <limits>
#include <messages.hpp>
#include <string>

#include "bench/common/hosts.h"
#include "bench/common/node_options.h"
#include "bench/common/process.h"
#include "bench/common/shared.h"
#include "bench/udp/udp.h"

namespace sft::bench {

namespace {

using sft_bench::Halves;
using F = Halves::Field;

constexpr std::size_t hosts_max = 9;
constexpr std::size_t half_bytes = 50'000;
constexpr std::int64_t period_us = 20'000;
constexpr std::uint64_t samples_before = 100;  // number of samples that are sent while multicast groups form
constexpr std::uint64_t samples = 50;

struct Board {
  std::atomic<std::size_t> ready{0};
  std::atomic<std::uint64_t> received{0};  ///< number of received samples, summed over the readers
  std::atomic<bool> over{false};
  double bytes = std::numeric_limits<double>::quiet_NaN();  ///< number of bytes per sample
};

class Source {
 public:
  Source() {
    halves_.left.resize(half_bytes, 1);
    halves_.right.resize(half_bytes, 2);
  }

  bool serves(std::size_t readers) const {
    const std::vector<PublisherStatus::Reader> all = publisher_.status().readers;
    return static_cast<std::size_t>(std::ranges::count_if(all, &PublisherStatus::Reader::served)) == readers;
  }
  /// Publishes samples. Returns the bytes that the host has sent during that time.
  double publish(std::uint64_t count) {
    const std::int64_t before = link_bytes().sent;
    for (std::uint64_t i = 0; i < count; ++i) {
      publisher_.publish(halves_);
      sleep_us(period_us);
    }
    return static_cast<double>(link_bytes().sent - before);
  }

 private:
  Node node_ = Node::open(udp_node_options("source")).value();
  Publisher<Halves> publisher_ = node_.publisher<Halves>("halves").value();
  Halves halves_;
};

int send(Board& board, std::size_t readers) {
  Source source;
  if (!wait_until([&] { return board.ready.load() == readers && source.serves(readers); })) return 1;
  source.publish(samples_before);
  const std::uint64_t received_before = board.received;
  const std::int64_t begin = now_ns();
  const double bytes = source.publish(samples);
  const std::int64_t took_us = (now_ns() - begin) / 1000;
  const auto received = static_cast<double>(board.received - received_before);
  const std::int64_t quiet_before = link_bytes().sent;
  sleep_us(took_us);
  const auto idle = static_cast<double>(link_bytes().sent - quiet_before);
  if (received >= static_cast<double>(samples * readers)) board.bytes = (bytes - idle) / samples;
  board.over = true;
  return 0;
}

template <class Mask>
void receive(Board& board, Mask subscribe) {
  Node node = Node::open(udp_node_options("reader")).value();
  const auto subscriber = subscribe(node, [&](const auto&) { ++board.received; });
  while (subscriber.status().writers.empty()) sleep_us(1000);
  ++board.ready;
  while (!board.over.load()) sleep_us(20'000);
}

void receive_left(Board& board) {
  receive(board, [](Node& node, auto count) {
    return node.subscriber<Halves, F::number | F::left>("halves", count).value();
  });
}
void receive_right(Board& board) {
  receive(board, [](Node& node, auto count) {
    return node.subscriber<Halves, F::number | F::right>("halves", count).value();
  });
}

/// Returns the bytes per sample that leave the publisher's host. All readers share the second core.
double bytes_for(std::size_t readers, const hosts::EmulatedNetwork& network) {
  const Shared<Board> board;
  const auto start = [&](std::size_t host, const std::function<int()>& run) {
    return start_on_core(host == 0 ? 0 : 1, [&] { return network.host(host).enter() ? run() : 1; });
  };
  std::vector<pid_t> started;
  for (std::size_t i = 0; i < readers; ++i) {
    started.push_back(start(i + 1, [&] {
      i % 2 == 0 ? receive_left(*board) : receive_right(*board);
      return 0;
    }));
  }
  const bool sent = succeeds(start(0, [&] { return send(*board, readers); }));
  for (const pid_t reader : started) {
    if (!sent) kill(reader, SIGKILL);
    succeeds(reader);
  }
  return board->bytes;
}

}  // namespace

std::vector<Figure> fan_out(const Scale&) {
  const hosts::EmulatedNetwork network = make_hosts(hosts_max, Trains::cut);
  const double one = bytes_for(1, network);
  std::vector<Figure> figures{{"fanout_1_reader", one, "B", {}, "per sample"}};
  for (const std::size_t readers : {2, 4, 8}) {
    figures.push_back({"fanout_" + std::to_string(readers) + "_readers_2_masks", bytes_for(readers, network),
                       "B", 2 * one, "two single copies", 1.1});
  }
  return figures;
}

}  // namespace sft::bench
