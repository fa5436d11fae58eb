// Measures how soon the first sample of a publisher on another host arrives by UDP: at a node that starts,
// and at a new subscriber of a node that the publisher's node knows. If no sample is kept for late readers,
// the publisher publishes ten thousand times per second. So the wait for the next sample is negligible.
#include <atomic>
#include <memory>
#include <string>

#include "bench/common/hosts.h"
#include "bench/common/statistics.h"
#include "bench/negotiation/negotiation.h"
#include "bench/negotiation/response.h"

namespace sft::bench {

namespace {

/// A program with SFT or with Cyclone DDS alone. The program with SFT waits for samples. The program with
/// Cyclone DDS has a listener that is called.
struct Contestant {
  Contender open;
  bool is_called;
};
constexpr Contestant sft_program{sft_peer, false}, cyclone_program{cyclone_control_peer, true};

/// The samples for late readers: only samples that are sent from then on, or the last earlier sample, too.
enum class Late { nothing, last_sample };

Topic topic_for(Late late) {
  return {.name = "points", .reliable = false, .durable = late == Late::last_sample};
}

class OneSample {
 public:
  OneSample(const Contestant& program, Peer& peer, const Topic& topic) : is_called_(program.is_called) {
    Arrived arrived;
    if (is_called_) arrived = [this](std::uint64_t) { note_arrival(); };
    reader_ = peer.reader(topic, std::move(arrived));
  }

  /// Waits for the sample. Returns false if the sample does not arrive within five seconds.
  bool wait() {
    if (is_called_) came_.wait(false);
    for (int second = 0; second < 5 && !came_; ++second) {
      reader_->wait();
      came_ = reader_->take() != 0;
    }
    return came_;
  }

 private:
  void note_arrival() {
    came_ = true;
    came_.notify_one();
  }

  const bool is_called_;
  std::atomic<bool> came_{false};
  std::unique_ptr<Reader> reader_;
};

constexpr std::int64_t period_us = 100;
constexpr std::int64_t settled_us = 100'000;  // the time after which the control traffic of a change is over

/// States if the publisher's node starts at the same moment, or has been running for a while.
enum class Sender { starts_too, runs };

/// Waits for the receiver, so that both sides continue at the same moment.
void meet_receiver(Exchange& exchange) {
  while (!exchange.ready.load()) {
  }
  exchange.sent = 1;
}
void meet_sender(Exchange& exchange) {
  exchange.ready = true;
  while (exchange.sent.load() == 0) {
  }
}

void send_until_over(Exchange& exchange, std::uint64_t readers, Writer& writer) {
  while (exchange.received.load() < readers && !exchange.failed.load()) {
    writer.write(1);
    sleep_us(period_us);
  }
}

void publish_to_new_node(Exchange& exchange, const Contestant& program, Sender publisher) {
  if (publisher == Sender::starts_too) meet_receiver(exchange);
  const auto peer = program.open();
  const auto writer = peer->writer(topic_for(Late::nothing));
  if (publisher == Sender::runs) {
    sleep_us(settled_us);
    meet_receiver(exchange);
  }
  send_until_over(exchange, 1, *writer);
}

void read_as_new_node(Exchange& exchange, const Contestant& program) {
  meet_sender(exchange);
  exchange.sent_at[0] = now_ns();
  const auto peer = program.open();
  OneSample reader(program, *peer, topic_for(Late::nothing));
  exchange.failed = !reader.wait();
  exchange.received_at[0] = now_ns();
  exchange.received = 1;
}

/// Starts new processes on both hosts, and adds the time to the first sample in milliseconds.
void start(const Contestant& program, const TwoHosts& hosts, Sender publisher, std::vector<double>& ms) {
  const auto us = run_pair(hosts.sides([=](Exchange& e) { publish_to_new_node(e, program, publisher); },
                                       [=](Exchange& e) { read_as_new_node(e, program); }),
                           1);
  for (const double time : us) ms.push_back(time / 1000);
}

/// Publishes to late readers. Exchange::sent shows whether there is a reader.
void publish_to_late_readers(Exchange& exchange, const Contestant& program, Late late,
                             std::uint64_t readers) {
  const auto peer = program.open();
  const auto first = peer->writer({.name = "first", .reliable = false});
  const auto writer = peer->writer(topic_for(late));
  writer->write(1);
  while (exchange.received.load() < readers && !exchange.failed.load()) {
    exchange.sent = writer->readers();
    if (late == Late::nothing) writer->write(1);
    first->write(1);
    sleep_us(period_us);
  }
}

void read_late(Exchange& exchange, const Contestant& program, Late late, std::uint64_t readers) {
  const auto peer = program.open();
  OneSample first(program, *peer, {.name = "first", .reliable = false});
  first.wait();
  for (std::uint64_t i = 0; i < readers && !exchange.failed.load(); ++i) {
    while (exchange.sent.load() != 0) sleep_us(period_us);
    sleep_us(5 * period_us);
    exchange.sent_at[i] = now_ns();
    OneSample reader(program, *peer, topic_for(late));
    exchange.failed = !reader.wait();
    exchange.received_at[i] = now_ns();
    while (exchange.sent.load() == 0 && !exchange.failed.load()) sleep_us(period_us);
    exchange.received = i + 1;
  }
}

std::vector<double> late_readers(const Contestant& program, const TwoHosts& hosts, Late late,
                                 std::uint64_t n) {
  return run_pair(hosts.sides([=](Exchange& e) { publish_to_late_readers(e, program, late, n); },
                              [=](Exchange& e) { read_late(e, program, late, n); }),
                  n);
}

Figure in_ms(Figure figure) {
  figure.value /= 1000;
  *figure.reference /= 1000;
  return figure;
}

}  // namespace

std::vector<Figure> first_sample_new_nodes(const Scale& scale) {
  const TwoHosts hosts;
  std::vector<double> both, second, both_raw, second_raw;
  for (int i = 0; i < scale.starts; ++i) {
    start(sft_program, hosts, Sender::starts_too, both);
    start(cyclone_program, hosts, Sender::starts_too, both_raw);
    start(sft_program, hosts, Sender::runs, second);
    start(cyclone_program, hosts, Sender::runs, second_raw);
  }
  const char* reference = "Cyclone DDS, domain to sample";
  return {{"first_sample_new_nodes", quantile(both, 0.5), "ms", quantile(both_raw, 0.5), reference, 50, true},
          {"first_sample_new_nodes_p90", quantile(both, 0.9), "ms", quantile(both_raw, 0.9), reference, {}},
          {"first_sample_second_node", quantile(second, 0.5), "ms", quantile(second_raw, 0.5), reference, 50,
           true},
          {"first_sample_second_node_p90",
           quantile(second, 0.9),
           "ms",
           quantile(second_raw, 0.9),
           reference,
           {}}};
}

std::vector<Figure> first_sample_late_reader(const Scale& scale) {
  const TwoHosts hosts;
  const std::uint64_t n = scale.late_readers;
  Rounds live, live_raw, kept, kept_raw;
  for (int round = 0; round < scale.rounds; ++round) {
    live.add(late_readers(sft_program, hosts, Late::nothing, n));
    live_raw.add(late_readers(cyclone_program, hosts, Late::nothing, n));
    kept.add(late_readers(sft_program, hosts, Late::last_sample, n));
    kept_raw.add(late_readers(cyclone_program, hosts, Late::last_sample, n));
  }
  const char* reference = "Cyclone DDS, reader to sample";
  return {in_ms({"first_sample_late_reader", live.p50(), "ms", live_raw.p50(), reference, 10, true}),
          in_ms({"first_sample_late_reader_p99", live.p99(), "ms", live_raw.p99(), reference, {}}),
          in_ms({"first_sample_kept", kept.p50(), "ms", kept_raw.p50(), reference, 10, true}),
          in_ms({"first_sample_kept_p99", kept.p99(), "ms", kept_raw.p99(), reference, {}})};
}

}  // namespace sft::bench
