#include "tests/hostile/forging_acts.h"

#include <algorithm>
#include <limits>
#include <map>
#include <memory>
#include <set>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "core/control/record_body.h"
#include "core/discovery/participant_data.h"
#include "tests/hostile/forged_control.h"
#include "tests/hostile/wire.h"
#include "tests/pairs/rtps_message.h"

namespace sft::hostile {

namespace {

using test::ControlParticipant;
using test::guessed_writers;
using test::RtpsMessage;

constexpr std::uint64_t greatest_revision = std::numeric_limits<std::uint64_t>::max();

/// Returns a function that calls `act` at each tenth call, which is ten times a second.
std::function<void()> now_and_then(std::function<void()> act) {
  constexpr int ticks_between = 10;
  return [act = std::move(act), ticks = std::make_shared<int>(0)] {
    if ((*ticks)++ % ticks_between == 0) act();
  };
}

core::ParticipantGuid octets_of(const dds_guid_t& guid) {
  core::ParticipantGuid octets{};
  std::ranges::copy(guid.v, octets.begin());
  return octets;
}

/// Returns an act that changes each record of this kind and writes it in the name of its writer with the
/// greatest revision. `change` returns the new body; an empty result means that the record is left
/// unchanged.
Act rewritten(core::RecordKind kind,
              std::function<std::vector<std::byte>(core::Role, std::span<const std::byte>)> change) {
  const auto forged_control = std::make_shared<ForgedControl>();
  const auto rewrite = [forged_control, kind, change = std::move(change)] {
    for (ForgedControl::HeardRecord heard : forged_control->records_heard()) {
      if (heard.sample.kind != static_cast<std::uint8_t>(kind) || heard.sample.body._length == 0) continue;
      std::vector<std::byte> body =
          change(heard.role, std::as_bytes(std::span(heard.sample.body._buffer, heard.sample.body._length)));
      if (body.empty()) continue;
      const auto size = static_cast<std::uint32_t>(body.size());
      heard.sample.revision = greatest_revision;
      heard.sample.body = {size, size, reinterpret_cast<std::uint8_t*>(body.data()), false};
      RtpsMessage message(heard.writer);
      message.add_heartbeat(test::far_ahead);
      message.add_record(test::far_ahead, heard.sample);
      message.send();
    }
  };
  return {.begin = {}, .go_on = now_and_then(rewrite)};
}

/// Returns true if the message belongs to the authentication of DDS Security: announcements of participants
/// with certificates, and messages of handshakes. Nothing protects these (SECURITY.md). All of them name the
/// method.
bool authenticates(std::span<const std::byte> message) {
  constexpr std::string_view method = "DDS:Auth:PKI-DH";
  return !std::ranges::search(message, std::as_bytes(std::span(method))).empty();
}

/// Returns an act that changes control messages of honest programs, but none that authenticates them, and
/// sends them again, in some cases in the names of these programs.
Act control_changed(Target& target, int at_a_time, std::function<void(Bytes&, Random&)> change) {
  struct State {
    explicit State(Random& numbers) : random(numbers) {}
    Listener listener{Listener::Traffic::control};
    Sender sender;
    Spoofer spoofer;
    std::vector<Overheard> kept;
    Random& random;
  };
  const auto state = std::make_shared<State>(target.random);
  return {.begin = {}, .go_on = [=] {
            constexpr std::size_t kept_max = 300;
            for (Overheard& heard : state->listener.listen()) {
              if (authenticates(heard.payload)) continue;
              if (state->kept.size() < kept_max) {
                state->kept.push_back(std::move(heard));
              } else {
                state->kept[state->random() % kept_max] = std::move(heard);
              }
            }
            for (int i = 0; i < at_a_time && !state->kept.empty(); ++i) {
              Overheard one = state->kept[state->random() % state->kept.size()];
              change(one.payload, state->random);
              state->random() % 2 == 0 ? state->spoofer.send(one.payload, one.from, one.to)
                                       : state->sender.send(one.payload, one.to);
            }
          }};
}

void mutate_body(Bytes& bytes, Random& random) {
  for (std::uint64_t changes = 1 + random() % 3; changes > 0; --changes) {
    std::byte& octet = bytes[random() % bytes.size()];
    octet = random() % 2 == 0 ? octet ^ static_cast<std::byte>(1U << random() % 8)
                              : static_cast<std::byte>(random() % 3 == 0 ? 0xff : random());
  }
  if (random() % 8 == 0) bytes.resize(1 + random() % bytes.size());
}

void cut_body(Bytes& bytes, Random& random) { bytes.resize(1 + random() % bytes.size()); }

}  // namespace

/// Disposes of all records, and withdraws the records of the first slots in the names of their writers. If
/// the writers are hidden, guesses them.
Act forged_disposals(Target& target) {
  const auto forged_control = std::make_shared<ForgedControl>(target.random() | 1);
  const auto dispose = [forged_control] {
    for (const ForgedControl::HeardRecord& heard : forged_control->records_heard())
      forged_control->dispose(heard.role, heard.sample);
    for (const ControlParticipant::Other& other : forged_control->participants()) {
      for (const dds_guid_t& writer : guessed_writers(other.guid)) {
        RtpsMessage message(writer);
        message.add_heartbeat(test::far_ahead);
        message.add_record(test::far_ahead,
                           test::to_sample(octets_of(other.guid), {}, {.revision = greatest_revision}));
        message.send();
      }
    }
  };
  return {.begin = {}, .go_on = now_and_then(dispose)};
}

/// Disposes of participants, as if their processes had ended.
Act forged_deaths(Target&) {
  const auto forged_control = std::make_shared<ForgedControl>();
  const auto dispose = [forged_control] {
    for (const ControlParticipant::Other& other : forged_control->participants()) {
      dds_guid_t writer = other.guid;
      std::ranges::copy(RtpsMessage::entity_of_participants, writer.v + 12);
      RtpsMessage message(writer);
      message.add_end(other.guid);
      message.send(RtpsMessage::Port::discovery);
    }
  };
  return {.begin = {}, .go_on = now_and_then(dispose)};
}

Act requests_with_the_last_number(Target&) {
  return rewritten(core::RecordKind::request, [](core::Role, std::span<const std::byte> body) {
    auto request = core::request_in(body);
    if (!request) return std::vector<std::byte>();
    request->sequence = core::request_sequence_max;
    request->listening.clear();
    request->attached.clear();
    return core::to_bytes(*request);
  });
}

Act altered_announcements(Target&) {
  return rewritten(core::RecordKind::announcement, [](core::Role role, std::span<const std::byte> body) {
    auto endpoint = core::endpoint_in(body);
    if (!endpoint || role != core::Role::reader) return std::vector<std::byte>();
    endpoint->node = made_up;
    endpoint->addresses = {own_address(9)};  // the port "discard"
    return core::to_bytes(*endpoint);
  });
}

/// Uses great sequence numbers, so that Cyclone DDS considers all later samples of these writers outdated.
Act outdated_records(Target&) {
  const auto forged_control = std::make_shared<ForgedControl>();
  const auto outdate = [forged_control] {
    for (const ControlParticipant::Other& other : forged_control->participants()) {
      for (const dds_guid_t& writer : guessed_writers(other.guid)) {
        RtpsMessage message(writer);
        message.add_heartbeat(test::far_ahead);
        message.send();
      }
    }
  };
  return {.begin = {}, .go_on = now_and_then(outdate)};
}

/// Makes participants that say that they belong to honest processes, replaces the announcements of these
/// processes, and includes its own records in the digests of its heartbeats.
Act impersonated_processes(Target&) {
  struct State {
    ForgedControl honest;
    std::map<core::ProcessId, std::unique_ptr<ForgedControl>> impostors;
    std::set<core::ParticipantGuid> own;
  };
  const auto state = std::make_shared<State>();
  const auto impersonate = [state] {
    for (const ControlParticipant::Other& other : state->honest.participants()) {
      const auto data = core::parse_participant_data(other.user_data);
      if (!data || state->impostors.contains(data->process)) continue;
      state->impostors[data->process] = std::make_unique<ForgedControl>(data->process);
    }
    for (const auto& [process, impostor] : state->impostors) {
      for (const core::Endpoint& endpoint : state->honest.heard())
        impostor->announce_bytes(endpoint.role, endpoint.id, {std::byte{0}});
      impostor->live();
    }
  };
  return {.begin = {}, .go_on = now_and_then(impersonate)};
}

/// Announces endpoints of other processes as its own, in their first state. A node that receives such an
/// announcement earlier than the genuine one keeps it.
Act copied_endpoints(Target& target) {
  const auto forged_control = std::make_shared<ForgedControl>(target.random() | 1);
  const auto first = std::make_shared<std::vector<core::Endpoint>>();
  return {.begin = {}, .go_on = [=] {
            const auto now = forged_control->heard();
            if (first->size() < now.size()) *first = now;
            for (const core::Endpoint& endpoint : *first) forged_control->announce(endpoint);
            forged_control->live();
          }};
}

/// Sends heartbeats in the names of honest participants, with wrong digests.
Act false_life(Target& target) {
  const auto forged_control = std::make_shared<ForgedControl>();
  const auto known = std::make_shared<std::map<core::ParticipantGuid, core::Heartbeat>>();
  return {.begin = {}, .go_on = [forged_control, known, &random = target.random] {
            for (const core::Heartbeat& heartbeat : forged_control->overheard())
              (*known)[heartbeat.participant] = heartbeat;
            for (auto& [participant, heartbeat] : *known) {
              heartbeat.digests = {random(), random()};
              forged_control->send(heartbeat);
            }
          }};
}

Act mutated_control(Target& target) { return control_changed(target, 15, mutate_body); }

Act truncated_control(Target& target) { return control_changed(target, 15, cut_body); }

Act replayed_control(Target& target) {
  return control_changed(target, 15, [](Bytes&, Random&) {});
}

}  // namespace sft::hostile
