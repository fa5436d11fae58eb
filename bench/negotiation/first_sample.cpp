// Measures how soon the first sample of a publisher on another host comes by UDP: to a node that starts, and
// to a new subscriber of a node that the publisher's node knows. If nothing is kept for late readers, the
// publisher publishes ten thousand times a second, so that waiting for the next sample does not count.
#include "bench/common/hosts.h"
#include "bench/common/statistics.h"
#include "bench/negotiation/contenders.h"
#include "bench/negotiation/negotiation.h"

namespace sft::bench {

namespace {

constexpr const char* topic = "points";
constexpr std::int64_t period_us = 100;
constexpr std::int64_t settled_us = 100'000;  // the control traffic of the last change is over

/// The publisher's node starts at the same moment, or has been running for a while.
enum class Sender { starts_too, runs };

/// Waits for the receiver, so that both sides go on at the same moment.
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

template <class Writer>
void send_until_over(Exchange& exchange, std::uint64_t readers, Writer& writer) {
  while (exchange.received.load() < readers && !exchange.failed.load()) {
    writer.send();
    sleep_us(period_us);
  }
}

template <class Program>
void publish_to_new_node(Exchange& exchange, Sender publisher) {
  if (publisher == Sender::starts_too) meet_receiver(exchange);
  Program program;
  typename Program::Writer writer(program, topic, Late::nothing);
  if (publisher == Sender::runs) {
    sleep_us(settled_us);
    meet_receiver(exchange);
  }
  send_until_over(exchange, 1, writer);
}

template <class Program>
void read_as_new_node(Exchange& exchange) {
  meet_sender(exchange);
  exchange.sent_at[0] = now_ns();
  Program program;
  typename Program::Reader reader(program, topic, Late::nothing);
  exchange.failed = !reader.wait();
  exchange.received_at[0] = now_ns();
  exchange.received = 1;
}

/// Starts new processes once, and adds the time to the first sample in milliseconds.
template <class Program>
void start(const TwoHosts& hosts, Sender publisher, std::vector<double>& ms) {
  const auto us = run_pair(hosts.sides([=](Exchange& e) { publish_to_new_node<Program>(e, publisher); },
                                       [](Exchange& e) { read_as_new_node<Program>(e); }),
                           1);
  for (const double time : us) ms.push_back(time / 1000);
}

/// Publishes to late readers. Reports in Exchange::sent whether there is a reader.
template <class Program>
void publish_to_late_readers(Exchange& exchange, Late late, std::uint64_t readers) {
  Program program;
  typename Program::Writer greeting(program, "greeting", Late::nothing);
  typename Program::Writer writer(program, topic, late);
  writer.send();
  while (exchange.received.load() < readers && !exchange.failed.load()) {
    exchange.sent = writer.readers();
    if (late == Late::nothing) writer.send();
    greeting.send();
    sleep_us(period_us);
  }
}

template <class Program>
void read_late(Exchange& exchange, Late late, std::uint64_t readers) {
  Program program;
  typename Program::Reader greeting(program, "greeting", Late::nothing);
  greeting.wait();
  for (std::uint64_t i = 0; i < readers && !exchange.failed.load(); ++i) {
    while (exchange.sent.load() != 0) sleep_us(period_us);
    sleep_us(5 * period_us);
    exchange.sent_at[i] = now_ns();
    typename Program::Reader reader(program, topic, late);
    exchange.failed = !reader.wait();
    exchange.received_at[i] = now_ns();
    while (exchange.sent.load() == 0 && !exchange.failed.load()) sleep_us(period_us);
    exchange.received = i + 1;
  }
}

template <class Program>
std::vector<double> late_readers(const TwoHosts& hosts, Late late, std::uint64_t n) {
  return run_pair(hosts.sides([=](Exchange& e) { publish_to_late_readers<Program>(e, late, n); },
                              [=](Exchange& e) { read_late<Program>(e, late, n); }),
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
    start<SftProgram>(hosts, Sender::starts_too, both);
    start<RawProgram>(hosts, Sender::starts_too, both_raw);
    start<SftProgram>(hosts, Sender::runs, second);
    start<RawProgram>(hosts, Sender::runs, second_raw);
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
    live.add(late_readers<SftProgram>(hosts, Late::nothing, n));
    live_raw.add(late_readers<RawProgram>(hosts, Late::nothing, n));
    kept.add(late_readers<SftProgram>(hosts, Late::last_sample, n));
    kept_raw.add(late_readers<RawProgram>(hosts, Late::last_sample, n));
  }
  const char* reference = "Cyclone DDS, reader to sample";
  return {in_ms({"first_sample_late_reader", live.p50(), "ms", live_raw.p50(), reference, 10, true}),
          in_ms({"first_sample_late_reader_p99", live.p99(), "ms", live_raw.p99(), reference, {}}),
          in_ms({"first_sample_kept", kept.p50(), "ms", kept_raw.p50(), reference, 10, true}),
          in_ms({"first_sample_kept_p99", kept.p99(), "ms", kept_raw.p99(), reference, {}})};
}

}  // namespace sft::bench
