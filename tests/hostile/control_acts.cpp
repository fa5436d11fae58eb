#include "tests/hostile/control_acts.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <memory>
#include <set>

#include "sft/dynamic_type.h"
#include "tests/hostile/forged_control.h"
#include "tests/hostile/wire.h"

namespace sft::hostile {

namespace {

using core::Endpoint;
using core::Role;

constexpr std::uint64_t last_number = std::numeric_limits<std::uint64_t>::max();

/// Returns a forged process with a random id.
std::shared_ptr<ForgedControl> forged_control_of(Target& target) {
  return std::make_shared<ForgedControl>(target.random() | 1);
}

/// Returns an act that at each tick calls `say` for every honest endpoint of that role.
Act to_each(Target& target, Role role, std::function<void(ForgedControl&, const Endpoint&)> say) {
  return {.begin = {}, .go_on = [forged_control = forged_control_of(target), role, say = std::move(say)] {
            for (const Endpoint& endpoint : forged_control->heard(role)) say(*forged_control, endpoint);
            forged_control->live();
          }};
}

/// Returns an act of a forged node, which announces `count` endpoints that `make` derives from an honest
/// endpoint of that role, some at each tick. The node also sends heartbeats, so that it counts as alive.
Act many_endpoints(
    Target& target, Role role, std::size_t count,
    std::function<Endpoint(const Endpoint& honest, std::uint64_t node, std::uint64_t number)> make) {
  struct State {
    explicit State(std::uint64_t id) : forged_control(id), node(id) {}
    ForgedControl forged_control;
    std::uint64_t node;
    std::size_t said = 0;
  };
  const auto state = std::make_shared<State>(target.random() | 1);
  constexpr std::size_t at_a_time = 200;
  return {.begin = {}, .go_on = [state, role, count, make = std::move(make)] {
            state->forged_control.live();
            const auto honest = state->forged_control.heard(role);
            if (honest.empty()) return;
            for (std::size_t i = 0; i < at_a_time && state->said < count; ++i)
              state->forged_control.announce(make(honest[0], state->node, ++state->said));
          }};
}

/// Returns an address at which no program listens: the port "discard".
std::vector<core::UdpAddress> nobody() { return {own_address(9)}; }

std::uint64_t id_of(std::uint64_t node, std::uint64_t number) { return node + (number << 20) + number; }

/// Returns the name in the form of type descriptions.
std::string described(const std::string& name) {
  return std::string(1, static_cast<char>(name.size())) + name;
}

/// Returns the description of a type with 4096 leaves, in some 200 bytes. It has twelve structs of two
/// members, and both members are of the preceding struct's type. `number` is part of each leaf's name.
std::vector<std::byte> deep_description(const std::string& type_name, std::uint64_t number) {
  constexpr int structs = 12;
  constexpr char uint8 = 4;
  constexpr char nested = 14;
  std::string text{'\x01', '\0', static_cast<char>(structs)};
  const std::string leaf = "l" + std::to_string(number);
  for (int depth = 0; depth < structs; ++depth) {
    text += described(depth + 1 == structs ? type_name : "s" + std::to_string(depth)) + '\2';
    for (const char* member : {"x", "y"}) {
      text += depth == 0 ? uint8 : nested;
      text += described(depth == 0 ? leaf + member : member);
      if (depth > 0) text += static_cast<char>(depth - 1);
    }
  }
  const auto* first = reinterpret_cast<const std::byte*>(text.data());
  return {first, first + text.size()};
}

/// Returns the description of the honest type with another name for one member.
std::vector<std::byte> renamed_description(std::vector<std::byte> description, std::uint64_t number) {
  constexpr std::string_view member = "is_bigendian";
  auto* text = reinterpret_cast<char*>(description.data());
  auto* found = std::search(text, text + description.size(), member.begin(), member.end());
  for (std::size_t i = 0; found != text + description.size() && i < 4; ++i, number /= 26)
    found[i] = static_cast<char>('a' + number % 26);
  return description;
}

Endpoint with_description(Endpoint reader, std::vector<std::byte> description) {
  if (const auto type = DynamicType::parse(description)) reader.type_hash = type->hash();
  reader.type_description = std::move(description);
  return reader;
}

Endpoint numbered_reader(const Endpoint& writer, std::uint64_t node, std::uint64_t number) {
  Endpoint reader = made_up_reader(writer, id_of(node, number), node, nobody());
  reader.type_description.clear();
  return reader;
}

/// Announces a reader at an address that never answers, and counts the bytes that arrive there.
Act reflection_to(Target& target, bool own_host_of_the_writer) {
  struct State {
    explicit State(std::uint64_t id) : node(id) {}
    ForgedControl forged_control;
    Drain drain;
    std::uint64_t node;
    std::set<core::EndpointId> known;
  };
  const auto state = std::make_shared<State>(target.random() | 1);
  return {.begin = {},
          .go_on =
              [=] {
                state->forged_control.live();
                state->drain.count();
                for (const Endpoint& writer : state->forged_control.heard(Role::writer)) {
                  if (writer.addresses.empty() || !state->known.insert(writer.id).second) continue;
                  Endpoint reader = made_up_reader(writer, id_of(state->node, 1), state->node,
                                                   {own_address(state->drain.port())});
                  reader.addresses[0].receive_buffer_bytes = 1U << 31;
                  if (own_host_of_the_writer) reader.network = writer.network;
                  state->forged_control.announce(reader);
                }
              },
          .end = {},
          .loot = [=]() -> std::string {
            constexpr std::uint64_t a_few_datagrams = 64 * 1024;
            if (state->drain.count() <= a_few_datagrams) return {};
            return "A host that never answered was sent " + std::to_string(state->drain.count()) + " bytes.";
          }};
}

}  // namespace

Act requests_to_nobody(Target& target) {
  return to_each(target, Role::reader, [](ForgedControl& forged_control, const Endpoint& reader) {
    core::Request request = reader.request;
    request.sequence += 100;
    request.mask_words = {1};
    request.listening.clear();
    request.attached.clear();
    forged_control.request(request);
  });
}

/// Repeats the records of other participants through its own writers, as a cache might do.
Act repeated_announcements(Target& target) {
  return {.begin = {}, .go_on = [forged_control = forged_control_of(target)] {
            for (const auto& heard : forged_control->records_heard())
              forged_control->write_raw(heard.role, heard.sample);
            forged_control->live();
          }};
}

Act ten_thousand_readers(Target& target) {
  return many_endpoints(target, Role::writer, 10'000, numbered_reader);
}

Act a_thousand_masks(Target& target) {
  return many_endpoints(target, Role::writer, 1000,
                        [](const Endpoint& writer, std::uint64_t node, std::uint64_t number) {
                          Endpoint reader = numbered_reader(writer, node, number);
                          reader.request.mask_words = {number};
                          return reader;
                        });
}

Act too_many_writers(Target& target) {
  return many_endpoints(target, Role::reader, 1100,
                        [](const Endpoint& reader, std::uint64_t node, std::uint64_t number) {
                          Endpoint writer = made_up_writer(reader, id_of(node, number), node);
                          writer.type_description.clear();
                          return writer;
                        });
}

Act two_thousand_definitions(Target& target) {
  return many_endpoints(target, Role::writer, 2000,
                        [](const Endpoint& writer, std::uint64_t node, std::uint64_t number) {
                          return with_description(numbered_reader(writer, node, number),
                                                  renamed_description(writer.type_description, number));
                        });
}

Act worst_definitions(Target& target) {
  return many_endpoints(target, Role::writer, 2000,
                        [](const Endpoint& writer, std::uint64_t node, std::uint64_t number) {
                          return with_description(numbered_reader(writer, node, number),
                                                  deep_description(writer.type_name, number));
                        });
}

Act names_with_control_characters(Target& target) {
  return many_endpoints(
      target, Role::writer, 20, [](const Endpoint& writer, std::uint64_t node, std::uint64_t number) {
        Endpoint reader = numbered_reader(writer, node, number);
        reader.node = number % 2 == 0 ? "x\n  [error] forged\x1b[2J" : std::string("\xff\xfe\xc0\x80", 4);
        if (number % 3 == 0) reader.topic = "points\n";
        return reader;
      });
}

/// Writes records with random bytes: announcements that are changed, cut or extended.
Act senseless_announcements(Target& target) {
  const auto random = std::make_shared<Random>(target.random());
  return to_each(target, Role::writer, [random](ForgedControl& forged_control, const Endpoint& writer) {
    const Endpoint reader = made_up_reader(writer, (*random)(), (*random)(), nobody());
    std::vector<std::byte> bytes = core::to_bytes(reader);
    for (std::uint64_t left = (*random)() % 20; left > 0; --left)
      bytes[(*random)() % bytes.size()] = static_cast<std::byte>((*random)());
    if ((*random)() % 3 == 0) bytes.resize((*random)() % (2 * bytes.size()));
    if (bytes.empty()) bytes.resize(1);
    forged_control.announce_bytes((*random)() % 2 == 0 ? Role::reader : Role::writer, (*random)() % 500,
                                  std::move(bytes));
  });
}

/// Announces writers whose short id is that of an honest writer, and whose whole id is smaller.
Act twin_writers(Target& target) {
  const std::uint64_t node = target.random();
  return to_each(target, Role::writer, [node](ForgedControl& forged_control, const Endpoint& writer) {
    Endpoint twin = made_up_writer(writer, writer.id & 0xffff'ffff, node);
    twin.addresses = nobody();
    forged_control.announce(twin);
  });
}

Act reflection(Target& target) { return reflection_to(target, false); }

Act reflection_to_the_own_host(Target& target) { return reflection_to(target, true); }

/// Reports progress of other processes' endpoints. Such reports must be ignored.
Act false_progress(Target& target) {
  const auto sent = std::make_shared<std::uint64_t>(1'000'000);
  return to_each(target, Role::writer, [sent](ForgedControl& forged_control, const Endpoint& writer) {
    forged_control.report({.living = {writer.id}, .progress = {{writer.id, *sent += 1000}}});
  });
}

/// Reports false accounts for each pair of two endpoints.
Act false_accounts(Target& target) {
  return {.begin = {}, .go_on = [forged_control = forged_control_of(target), &random = target.random] {
            const std::vector<Endpoint> all = forged_control->heard();
            for (const Endpoint& one : all) {
              core::NodeReport report;
              for (const Endpoint& other : all) {
                core::Account account{
                    .id = {{one.id, other.id}, random() % 2 == 0 ? Role::writer : Role::reader}};
                account.by_writer = {.sent = random(), .bytes_saved = last_number};
                account.by_reader = {.received = last_number, .lost = random()};
                report.accounts.push_back(account);
              }
              forged_control->report(report);
            }
            forged_control->live();
          }};
}

/// Sends inquiries about all topics, and about many topics that do not exist, alternately for accounts and
/// for progress.
Act questions_without_end(Target& target) {
  const auto asked = std::make_shared<std::uint64_t>(0);
  return {.begin = {}, .go_on = [forged_control = forged_control_of(target), asked] {
            constexpr std::uint64_t at_a_time = 20, topics = 10'000;
            forged_control->inquire(0, {.topic = "", .wants_accounts = *asked % 2 == 0});
            for (std::uint64_t i = 0; i < at_a_time; ++i, ++*asked) {
              const std::uint64_t number = 1 + *asked % topics;
              forged_control->inquire(number,
                                      {.topic = "t" + std::to_string(number), .wants_accounts = i % 2 == 0});
            }
            ++*asked;
            forged_control->live();
          }};
}

/// Writes records of kinds and versions that do not exist, in its own name and in the names of other
/// participants.
Act unknown_records(Target& target) {
  return {.begin = {}, .go_on = [forged_control = forged_control_of(target), &random = target.random] {
            for (ForgedControl::HeardRecord heard : forged_control->records_heard()) {
              const std::uint64_t numbers = random();
              std::uint8_t& changed = numbers % 2 == 0 ? heard.sample.kind : heard.sample.version;
              changed = static_cast<std::uint8_t>(128 + numbers % 128);
              heard.sample.slot = static_cast<std::uint32_t>(numbers >> 32);
              heard.sample.revision = last_number - numbers % 3;
              const Role role = numbers % 5 < 2 ? Role::writer : Role::reader;
              numbers % 7 < 3 ? forged_control->write_as_own(role, heard.sample)
                              : forged_control->write_raw(role, heard.sample);
            }
            forged_control->live();
          }};
}

/// Writes senseless announcements, each in its own slot.
Act slots_without_end(Target& target) {
  const auto slots = std::make_shared<std::uint64_t>(0);
  return {.begin = {}, .go_on = [forged_control = forged_control_of(target), slots, &random = target.random] {
            constexpr std::uint64_t at_a_time = 200, most = 40'000;
            for (std::uint64_t i = 0; i < at_a_time && *slots < most; ++i)
              forged_control->announce_bytes(Role::writer, ++*slots, Bytes(1 + random() % 500));
            forged_control->live();
          }};
}

/// Sends heartbeats with random digests, so that records of the attacker's process always seem to be
/// missing.
Act heartbeats_without_records(Target& target) {
  return {.begin = {}, .go_on = [forged_control = forged_control_of(target), &random = target.random] {
            forged_control->live({random(), random()});
          }};
}

/// Sends heartbeats of hosts that do not exist.
Act flood_of_heartbeats(Target& target) {
  return {.begin = {}, .go_on = [forged_control = forged_control_of(target), &random = target.random] {
            constexpr int at_a_time = 300;
            for (int i = 0; i < at_a_time; ++i) {
              core::Heartbeat heartbeat{.process = random(), .digests = {random(), random()}};
              for (std::uint8_t& octet : heartbeat.participant) octet = static_cast<std::uint8_t>(random());
              forged_control->send(heartbeat);
            }
          }};
}

}  // namespace sft::hostile
