#include "bench/paper/trace.h"

#include <fmt/format.h>
#include <unistd.h>

#include <ostream>

#include "bench/common/host_processes.h"
#include "bench/common/pair.h"
#include "bench/common/shared.h"
#include "bench/paper/messages.h"

namespace sft::bench::paper {

namespace {

constexpr std::size_t messages_sent = 10;
constexpr std::int64_t period_us = 100'000;
constexpr const char* topic = "trace";

struct Board {
  std::atomic<std::int64_t> applied_ns{0};
  std::atomic<std::int64_t> first_ns{0};
  std::atomic<std::size_t> received{0};
  std::int64_t received_ns[messages_sent] = {};
  std::int64_t read_ns[messages_sent] = {};
  std::size_t cdr_bytes[messages_sent] = {};
};

Node open_node() { return Node::open({.name = "trace", .transport = TransportChoice::udp}).value(); }

SharedMessages messages() { return parametric_messages(7, 512); }

int publish(Board& board) {
  const auto note = [&](const PublisherStatus& status) {
    const bool applied =
        !status.readers.empty() && status.readers[0].served && !status.readers[0].mask.is_full();
    if (applied && board.applied_ns.load() == 0) board.applied_ns = now_ns();
  };
  Node node = open_node();
  const SharedMessages sent = messages();
  const auto writer = sent->writer(node, topic, {.on_readers_changed = note});
  if (!wait_until([&] { return writer->serves(1); })) return 1;
  board.first_ns = now_ns();
  for (std::size_t i = 0; i < messages_sent; ++i) {
    writer->write(0);
    sleep_us(period_us);
  }
  return 0;
}

void read(const DynamicSample& sample, Board& board) {
  const std::size_t number = board.received.load();
  if (number == messages_sent) return;
  board.received_ns[number] = now_ns();
  for (const char* field : {"a", "c", "e", "g"}) (void)static_cast<bool>(sample.view()[field]);
  constexpr std::size_t encapsulation_bytes = 4;
  board.cdr_bytes[number] = sample.cdr().size() - encapsulation_bytes;
  board.read_ns[number] = now_ns();
  board.received = number + 1;
}

int subscribe(Board& board) {
  Node node = open_node();
  const auto type = node.find_type(topic, std::chrono::seconds(10)).value();
  const auto subscriber =
      node.subscriber(topic, type, recorded, {}, [&](const DynamicSample& sample) { read(sample, board); })
          .value();
  for (;;) pause();
}

}  // namespace

std::optional<Trace> response_trace() {
  const Shared<Board> board;
  HostProcesses processes(1);
  processes.start(0, [&] { return publish(*board); });
  processes.start(1, [&] { return subscribe(*board); });
  if (!processes.first_succeeds() || board->applied_ns.load() == 0) return std::nullopt;
  const auto ms = [&](std::int64_t ns) { return static_cast<double>(ns - board->first_ns.load()) / 1e6; };
  Trace trace{.applied_ms = ms(board->applied_ns)};
  for (std::size_t i = 0; i < board->received.load(); ++i) {
    trace.messages.push_back({ms(board->received_ns[i]), static_cast<double>(board->cdr_bytes[i])});
    if (const double read_ms = ms(board->read_ns[i]); read_ms < trace.applied_ms) trace.changed_ms = read_ms;
  }
  return trace;
}

void write(std::ostream& out, const Trace& trace) {
  out << "event,ms,bytes\n";
  for (const Trace::Message& message : trace.messages)
    out << fmt::format("message,{:.4f},{:.0f}\n", message.at_ms, message.cdr_bytes);
  out << fmt::format("changed,{:.4f},\napplied,{:.4f},\n", trace.changed_ms, trace.applied_ms) << std::flush;
}

}  // namespace sft::bench::paper
