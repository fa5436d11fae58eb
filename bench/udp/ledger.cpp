#include "bench/udp/ledger.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "bench/common/statistics.h"

namespace sft::bench {

namespace {

double us(std::int64_t ns) { return static_cast<double>(ns) / 1000; }

std::string line(const char* name, double us, double total, double median) {
  return fmt::format("    {:<40} {:>10.1f} us {:>6.1f} % {:>12.1f} us\n", name, us, 100 * us / total, median);
}

}  // namespace

double Ledger::total() const { return std::accumulate(phases.begin(), phases.end(), 0.); }

void Traffic::add(const Packet& packet) {
  if (packets++ == 0) first_ns = last_ns = packet.at_ns;
  if (packet.at_ns - last_ns > pause_ns) {
    pause_ns = packet.at_ns - last_ns;
    pause_at_ns = last_ns;
  }
  last_ns = packet.at_ns;
  bytes += packet.bytes;
}

Traffic traffic(const std::vector<Packet>& packets, const Delivery& during, bool outgoing,
                Packet::Kind kind) {
  Traffic sum;
  for (const Packet& packet : packets) {
    if (packet.outgoing == outgoing && packet.kind == kind && packet.at_ns >= during.sent_at &&
        packet.at_ns <= during.received_at)
      sum.add(packet);
  }
  return sum;
}

std::optional<Ledger> ledger_of(const Delivery& delivery, const std::vector<Packet>& at_sender,
                                const std::vector<Packet>& at_receiver) {
  const Traffic leaves = traffic(at_sender, delivery, true, Packet::Kind::data);
  const Traffic arrives = traffic(at_receiver, delivery, false, Packet::Kind::data);
  if (leaves.packets == 0 || arrives.packets == 0) return std::nullopt;
  const std::array ends{leaves.first_ns, arrives.first_ns, leaves.last_ns, arrives.last_ns,
                        delivery.received_at};
  Ledger ledger{.publishing = us(delivery.returned_at - delivery.sent_at),
                .data_pause = us(arrives.pause_ns),
                .answer_pause = us(traffic(at_sender, delivery, false, Packet::Kind::answer).pause_ns)};
  std::int64_t begin = delivery.sent_at;
  for (std::size_t i = 0; i < ends.size(); ++i) {
    const std::int64_t end = std::max(begin, ends[i]);
    ledger.phases[i] = us(end - begin);
    begin = end;
  }
  return ledger;
}

Ledger medians_of(const std::vector<Ledger>& ledgers) {
  const auto of = [&](auto line) {
    std::vector<double> values;
    for (const Ledger& ledger : ledgers) values.push_back(line(ledger));
    return median(values);
  };
  Ledger medians{.publishing = of([](const Ledger& one) { return one.publishing; }),
                 .data_pause = of([](const Ledger& one) { return one.data_pause; }),
                 .answer_pause = of([](const Ledger& one) { return one.answer_pause; })};
  for (std::size_t i = 0; i < medians.phases.size(); ++i)
    medians.phases[i] = of([=](const Ledger& one) { return one.phases[i]; });
  return medians;
}

std::string table_of(const Ledger& ledger, const Ledger& medians) {
  const double total = ledger.total();
  std::string table =
      fmt::format("    {:<40} {:>13} {:>8} {:>15}\n", "phase", "this sample", "share", "median of all");
  for (std::size_t i = 0; i < ledger.phases.size(); ++i)
    table += line(Ledger::phase_names[i], ledger.phases[i], total, medians.phases[i]);
  table += fmt::format("    {:<40} {:>10.1f} us {:>6.1f} %\n", "sum", total, 100.);
  table += "    meanwhile:\n";
  table += line("publish() called .. returned", ledger.publishing, total, medians.publishing);
  table += line("longest pause of the arriving sample", ledger.data_pause, total, medians.data_pause);
  table += line("longest pause between answers", ledger.answer_pause, total, medians.answer_pause);
  return table;
}

}  // namespace sft::bench
