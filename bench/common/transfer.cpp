#include "bench/common/transfer.h"

namespace sft::bench {

namespace {

std::int64_t pause_between(Reading reading) { return reading == Reading::sleeping ? 150 : 5; }

}  // namespace

void send_each(Exchange& exchange, const Transfer& transfer, Writer& writer) {
  exchange.failed = !wait_until([&] { return exchange.ready.load() && writer.serves(1); });
  for (std::uint64_t i = 0; i < transfer.messages && !exchange.failed; ++i) {
    pause_us(pause_between(transfer.reading));
    if (transfer.preparing_counts) exchange.sent_at[i] = now_ns();
    writer.prepare(i + 1);
    if (!transfer.preparing_counts) exchange.sent_at[i] = now_ns();
    writer.publish();
    if (!exchange.wait_for_receipt(i + 1)) exchange.failed = true;
  }
}

void receive_each(Exchange& exchange, const Transfer& transfer, Reader& reader) {
  while (reader.writers() == 0) sleep_us(1000);
  exchange.ready = true;
  while (exchange.received.load() < transfer.messages && !exchange.failed.load()) {
    if (transfer.reading == Reading::sleeping) reader.wait();
    if (const std::uint64_t number = reader.take()) exchange.note_receipt(number);
  }
}

std::vector<double> transfer_times(Contender contender, const Topic& topic, const Transfer& transfer) {
  return run_pair({.sender =
                       [&](Exchange& exchange) {
                         const auto peer = contender();
                         send_each(exchange, transfer, *peer->writer(topic));
                       },
                   .receiver =
                       [&](Exchange& exchange) {
                         const auto peer = contender();
                         receive_each(exchange, transfer, *peer->reader(topic));
                       }},
                  transfer.messages);
}

}  // namespace sft::bench
