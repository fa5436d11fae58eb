// Passes messages from one process to another one on the same host, one after the other. Each contender has
// the same interface:
//
//   Writer   serves(readers)   true if so many readers get what is published from now on
//            prepare(number)   makes the next message, so that publish() can hand it over
//            publish()         hands the message over
//   Reader   wait()            waits until there is a message to take
//            take()            reads the next message and returns its number; 0: there is none
//            writers()         the number of writers that it is connected to
//
// Readers that a thread of their library calls are made with an Arrived, and have only writers().
#pragma once

#include "bench/common/pair.h"

namespace sft::bench {

enum class Reading { spinning, sleeping };

struct Transfer {
  std::uint64_t messages = 0;
  Reading reading = Reading::sleeping;
  bool preparing_counts = false;
};

/// The pause in microseconds in which a reader that sleeps falls asleep.
constexpr std::int64_t pause_between(Reading reading) { return reading == Reading::sleeping ? 150 : 5; }

template <class Writer>
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

template <class Reader>
void receive_each(Exchange& exchange, const Transfer& transfer, Reader& reader) {
  while (reader.writers() == 0) sleep_us(1000);
  exchange.ready = true;
  while (exchange.received.load() < transfer.messages && !exchange.failed.load()) {
    if (transfer.reading == Reading::sleeping) reader.wait();
    if (const std::uint64_t number = reader.take()) exchange.note_receipt(number);
  }
}

/// Called with the number of each message after it was read.
using Arrived = std::function<void(std::uint64_t)>;

template <class CalledReader>
void be_called(Exchange& exchange, const Transfer& transfer) {
  CalledReader reader([&](std::uint64_t number) { exchange.note_receipt(number); });
  while (reader.writers() == 0) sleep_us(1000);
  exchange.ready = true;
  while (exchange.received.load() < transfer.messages && !exchange.failed.load()) sleep_us(10'000);
}

/// One-way times in microseconds. `arguments` are for the writer's constructor.
template <class Writer, class Reader, class... Arguments>
std::vector<double> transfer_times(const Transfer& transfer, const Arguments&... arguments) {
  return run_pair({.sender =
                       [&](Exchange& exchange) {
                         Writer writer(arguments...);
                         send_each(exchange, transfer, writer);
                       },
                   .receiver =
                       [&](Exchange& exchange) {
                         Reader reader;
                         receive_each(exchange, transfer, reader);
                       }},
                  transfer.messages);
}

}  // namespace sft::bench
