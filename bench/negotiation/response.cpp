#include "bench/negotiation/response.h"

#include <sensor_msgs/msg/PointCloud2.hpp>

#include "bench/common/statistics.h"
#include "bench/negotiation/negotiation.h"
#include "bench/negotiation/raw_cyclone.h"

namespace sft::bench {

namespace {

struct HeightProbe {
  using Message = sensor_msgs::msg::PointCloud2;
  static constexpr auto wanted = Message::Field::height;
  static void read_usual(const auto& sample) { (void)sample->width(); }
  static void read_wanted(const auto& sample) { (void)sample->height(); }
};

void write(Exchange& exchange, std::uint64_t messages) {
  RawCyclone cyclone;
  const dds_entity_t writer = cyclone.writer("requests", RawCyclone::Delivery::last_value);
  while (!exchange.ready.load() || RawCyclone::readers(writer) == 0) sleep_us(1000);
  for (std::uint64_t i = 0; i < messages; ++i) {
    sleep_us(1000);
    exchange.sent_at[i] = now_ns();
    RawCyclone::write(writer, i + 1);
  }
}

void listen(Exchange& exchange, std::uint64_t messages) {
  const RawCyclone::Arrived note = [&](std::uint64_t number) {
    exchange.received_at[number - 1] = now_ns();
    exchange.received.store(number, std::memory_order_release);
  };
  RawCyclone cyclone;
  cyclone.reader("requests", RawCyclone::Delivery::last_value, note);
  exchange.ready = true;
  while (exchange.received.load() < messages && !exchange.failed.load()) sleep_us(1000);
}

}  // namespace

std::vector<double> dds_write_times(const TwoHosts& hosts, std::uint64_t messages) {
  return run_pair(
      hosts.sides([=](Exchange& e) { write(e, messages); }, [=](Exchange& e) { listen(e, messages); }),
      messages);
}

std::vector<Figure> str_response(const Scale& scale) {
  const TwoHosts hosts;
  Rounds ours, raw;
  for (int round = 0; round < scale.rounds; ++round) {
    ours.add(response_times<HeightProbe>(hosts, scale.messages));
    raw.add(dds_write_times(hosts, scale.messages));
  }
  const char* reference = "dds_write to a listener";
  return {{"str_response", ours.p50(), "us", raw.p50(), reference, 100, true},
          {"str_response_p99", ours.p99(), "us", raw.p99(), reference, 1000, true}};
}

}  // namespace sft::bench
