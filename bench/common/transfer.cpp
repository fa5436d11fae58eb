#include "bench/common/transfer.h"

namespace sft::bench {

namespace {

std::int64_t pause_between(Reading reading) { return reading == Reading::sleeping ? 150 : 5; }

void send(Exchange& exchange, Contender contender, const Topic& topic, const Transfer& transfer,
          std::int64_t connecting_us) {
  const auto peer = contender();
  const auto writer = peer->writer(topic);
  if (connecting_us > 0) {
    wait_until([&] { return exchange.ready.load() && writer->serves(1); });
    sleep_us(connecting_us);
  }
  send_each(exchange, transfer, *writer);
}

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
  return run_pair({.sender = [&](Exchange& exchange) { send(exchange, contender, topic, transfer, 0); },
                   .receiver =
                       [&](Exchange& exchange) {
                         const auto peer = contender();
                         receive_each(exchange, transfer, *peer->reader(topic));
                       }},
                  transfer.messages);
}

std::vector<double> called_times(Contender contender, const Topic& topic, const Transfer& transfer,
                                 const std::function<void()>& enter, std::int64_t connecting_us) {
  const auto receive = [&](Exchange& exchange) {
    const auto peer = contender();
    const auto reader = peer->reader(topic, [&](std::uint64_t number) { exchange.note_receipt(number); });
    while (reader->writers() == 0) sleep_us(1000);
    exchange.ready = true;
    while (exchange.received.load() < transfer.messages && !exchange.failed.load()) sleep_us(10'000);
  };
  return run_pair({.sender = [&](Exchange& e) { send(e, contender, topic, transfer, connecting_us); },
                   .receiver = receive,
                   .enter_sender = enter,
                   .enter_receiver = enter},
                  transfer.messages);
}

}  // namespace sft::bench
