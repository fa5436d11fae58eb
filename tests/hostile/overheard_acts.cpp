#include "tests/hostile/overheard_acts.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <map>
#include <memory>

#include "tests/hostile/wire.h"
#include "tests/support/parse_datagram.h"
#include "udp_transport/wire/datagram.h"

namespace sft::hostile {

namespace {

udp::DatagramKind kind_of(const Overheard& heard) {
  return udp::kind_of(heard.payload).value_or(udp::DatagramKind::first);
}

/// Returns an act that at each tick calls `use` for each datagram overheard since the last tick.
Act with_overheard(std::function<void(const Overheard&)> use) {
  const auto listener = std::make_shared<Listener>();
  return {.begin = {}, .go_on = [listener, use = std::move(use)] {
            for (const Overheard& heard : listener->listen()) use(heard);
          }};
}

/// The newest datagrams of each kind; only a few of each are kept.
class Collection {
 public:
  void keep(const Overheard& heard) {
    auto& kept = by_kind_[kind_of(heard)];
    if (kept.size() == kept_of_each_kind) kept.erase(kept.begin());
    kept.push_back(heard);
  }
  bool empty() const { return by_kind_.empty(); }
  const Overheard& any(Random& random) const {
    auto kind = by_kind_.begin();
    std::advance(kind, random() % by_kind_.size());
    return kind->second[random() % kind->second.size()];
  }

 private:
  static constexpr std::size_t kept_of_each_kind = 40;
  std::map<udp::DatagramKind, std::vector<Overheard>> by_kind_;
};

using Change = std::function<void(Bytes&, Random&)>;

/// Returns an act that at each tick changes `at_a_time` of the overheard datagrams for whose kind `wanted`
/// returns true, and sends them to their original destinations.
Act changed(Target& target, int at_a_time, std::function<bool(udp::DatagramKind)> wanted, Change change) {
  struct State {
    explicit State(Random& numbers) : random(numbers) {}
    Listener listener;
    Sender sender;
    Spoofer spoofer;
    Collection collection;
    Random& random;
  };
  const auto state = std::make_shared<State>(target.random);
  return {.begin = {}, .go_on = [=] {
            for (const Overheard& heard : state->listener.listen()) {
              if (wanted(kind_of(heard))) state->collection.keep(heard);
            }
            if (state->collection.empty()) return;
            for (int i = 0; i < at_a_time; ++i) {
              Overheard one = state->collection.any(state->random);
              change(one.payload, state->random);
              // Half of them have the true source address.
              state->random() % 2 == 0 ? state->spoofer.send(one.payload, one.from, one.to)
                                       : state->sender.send(one.payload, one.to);
            }
          }};
}

bool any_kind(udp::DatagramKind) { return true; }

template <class Number>
void put(Bytes& bytes, std::size_t at, Number number) {
  if (at + sizeof number <= bytes.size()) std::memcpy(bytes.data() + at, &number, sizeof number);
}

/// Returns a random offset within the headers. It is either a multiple of `step`, where most headers have
/// their numbers, or any offset, because following datagrams have their numbers at other offsets.
std::size_t any_place(const Bytes& bytes, Random& random, std::size_t step) {
  constexpr std::size_t headers_bytes = 72;
  if (random() % 2 == 0) step = 1;
  return random() % std::max<std::size_t>(std::min(bytes.size(), headers_bytes) / step, 1) * step;
}

std::uint64_t notable_number(Random& random) {
  static constexpr std::array<std::uint64_t, 14> numbers{0,
                                                         1,
                                                         2,
                                                         255,
                                                         4096,
                                                         65'535,
                                                         65'536,
                                                         0x7fff'ffff,
                                                         0x8000'0000,
                                                         0xffff'ffff,
                                                         far_future,
                                                         far_future - 1,
                                                         std::uint64_t{1} << 63,
                                                         std::numeric_limits<std::uint64_t>::max()};
  return numbers[random() % numbers.size()];
}

void flip_a_bit(Bytes& bytes, Random& random) {
  bytes[any_place(bytes, random, 1)] ^= static_cast<std::byte>(1U << random() % 8);
}
void write_a_notable_number(Bytes& bytes, Random& random) {
  const std::uint64_t number = notable_number(random);
  random() % 2 == 0 ? put(bytes, any_place(bytes, random, 8), number)
                    : put(bytes, any_place(bytes, random, 4), static_cast<std::uint32_t>(number));
}
void shift_a_number(Bytes& bytes, Random& random) {
  const std::size_t at = any_place(bytes, random, 4);
  std::uint32_t number = 0;
  if (at + sizeof number > bytes.size()) return;
  std::memcpy(&number, bytes.data() + at, sizeof number);
  put(bytes, at, static_cast<std::uint32_t>(number + random() % 20'000 - 10'000));
}
void cut_off(Bytes& bytes, Random& random) { bytes.resize(1 + random() % bytes.size()); }
void change_kind(Bytes& bytes, Random& random) {
  constexpr auto kinds = static_cast<std::uint64_t>(udp::DatagramKind::far);
  bytes[0] = static_cast<std::byte>(udp::wire_version << 4 | (1 + random() % kinds));
}
void change_flags(Bytes& bytes, Random& random) { bytes[1] = static_cast<std::byte>(random()); }

void mutate(Bytes& bytes, Random& random) {
  static constexpr std::array changes{
      flip_a_bit, write_a_notable_number, shift_a_number, cut_off, change_kind, change_flags};
  for (std::uint64_t i = 0; i < 1 + random() % 3; ++i) {
    if (bytes.size() >= 2) changes[random() % changes.size()](bytes, random);
  }
}

/// Returns an act that answers each overheard heartbeat by the ack that `answer` returns; the ack is sent
/// to the writer in the reader's name.
Act for_heartbeats(std::function<udp::Ack(const udp::Heartbeat&)> answer) {
  const auto spoofer = std::make_shared<Spoofer>();
  return with_overheard([spoofer, answer = std::move(answer)](const Overheard& heard) {
    const auto heartbeat = udp::parse_as<udp::Heartbeat>(heard.payload);
    if (!heartbeat) return;
    const udp::Ack ack = answer(*heartbeat);
    spoofer->send(encoded(ack, ack.bytes()), heard.to, to_port(heard.from.sin_addr.s_addr, heartbeat->port));
  });
}

}  // namespace

/// Uses the numbers of channels in use, and sends two heartbeats, so that the second heartbeat confirms the
/// first.
Act heartbeats_a_little_ahead(Target&) {
  const auto spoofer = std::make_shared<Spoofer>();
  const auto ticks = std::make_shared<int>(0);
  return with_overheard([=](const Overheard& heard) {
    const auto honest = udp::parse_as<udp::Heartbeat>(heard.payload);
    constexpr int heartbeats_between = 10;
    if (!honest || ++*ticks % heartbeats_between != 0) return;
    udp::Heartbeat ahead = *honest;
    for (int i = 0; i < 2; ++i) {
      ahead.first = ahead.end += 100'000;
      spoofer->send(encoded(ahead, udp::heartbeat_bytes), heard.from, heard.to);
    }
  });
}

Act overheard_acks(Target&) {
  return for_heartbeats([](const udp::Heartbeat& heartbeat) {
    return udp::Ack{heartbeat.writer, heartbeat.channel, heartbeat.end + 1'000'000};
  });
}

Act forged_nacks(Target&) {
  return for_heartbeats([](const udp::Heartbeat& heartbeat) {
    udp::Ack ack{heartbeat.writer, heartbeat.channel, heartbeat.first};
    for (; ack.missing_count < udp::missing_max; ++ack.missing_count)
      ack.missing[ack.missing_count] = {static_cast<std::uint32_t>(heartbeat.first + ack.missing_count), 0,
                                        0};
    return ack;
  });
}

Act forged_reports(Target&) {
  const auto spoofer = std::make_shared<Spoofer>();
  return with_overheard([spoofer](const Overheard& heard) {
    const auto mark = udp::parse_as<udp::FlowMark>(heard.payload);
    if (!mark) return;
    const udp::FlowReport report{.flow = mark->flow,
                                 .position = mark->position,
                                 .window_bytes = 0,
                                 .datagrams = mark->datagrams,
                                 .came = 0,
                                 .sent_at_ns = mark->sent_at_ns};
    spoofer->send(encoded(report, udp::report_bytes), heard.to,
                  to_port(heard.from.sin_addr.s_addr, mark->port));
  });
}

/// Sends heartbeats for the writer's channels that name another host, to which acks would then be sent
/// although that host never requested them.
Act heartbeats_that_name_another_host(Target&) {
  const auto drain = std::make_shared<Drain>();
  const auto sender = std::make_shared<Sender>();
  Act act = with_overheard([=](const Overheard& heard) {
    auto heartbeat = udp::parse_as<udp::Heartbeat>(heard.payload);
    if (!heartbeat) return;
    heartbeat->port = drain->port();
    heartbeat->end += 4'000'000;
    sender->send(encoded(*heartbeat, udp::heartbeat_bytes), heard.to);
  });
  act.loot = [drain]() -> std::string {
    constexpr std::uint64_t a_few_datagrams = 4096;
    if (drain->count() <= a_few_datagrams) return {};
    return "A host that no writer is on was sent " + std::to_string(drain->count()) + " bytes of acks.";
  };
  return act;
}

Act replayed_datagrams(Target&) {
  const auto spoofer = std::make_shared<Spoofer>();
  return with_overheard([spoofer](const Overheard& heard) {
    for (int i = 0; i < 3; ++i) spoofer->send(heard.payload, heard.from, heard.to);
  });
}

/// Sends the first overheard datagrams again and again, so that these become older and older.
Act replayed_datagrams_of_long_ago(Target&) {
  const auto spoofer = std::make_shared<Spoofer>();
  const auto first = std::make_shared<std::vector<Overheard>>();
  constexpr std::size_t kept = 100;
  Act act = with_overheard([=](const Overheard& heard) {
    if (first->size() < kept) first->push_back(heard);
  });
  act.go_on = [=, listen = act.go_on] {
    listen();
    for (const Overheard& one : *first) spoofer->send(one.payload, one.from, one.to);
  };
  return act;
}

Act mutated_datagrams(Target& target) { return changed(target, 100, any_kind, mutate); }

Act mutated_samples(Target& target) {
  return changed(
      target, 100, [](udp::DatagramKind kind) { return !is_answer(kind); }, mutate);
}

Act mutated_answers(Target& target) { return changed(target, 100, udp::is_answer, mutate); }

Act bit_flips(Target& target) { return changed(target, 50, any_kind, flip_a_bit); }

Act largest_numbers(Target& target) { return changed(target, 50, any_kind, write_a_notable_number); }

Act truncated_datagrams(Target& target) { return changed(target, 50, any_kind, cut_off); }

}  // namespace sft::hostile
