#include "tests/pairs/forger.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>

#include "core/control/record_body.h"
#include "core/discovery/participant_data.h"
#include "tests/pairs/rtps_message.h"

namespace sft::test {

namespace {

constexpr dds_domainid_t domain_0 = 0;
constexpr const char* interface = "eth0";
constexpr core::ProcessId made_up_process = 0x5f07'6e4d;
constexpr std::uint64_t revisions_ahead = 1000;

template <class Sample, class Use>
void read_all(dds_entity_t reader, Use use) {
  constexpr std::size_t samples_max = 256;
  std::vector<void*> samples(samples_max);
  std::vector<dds_sample_info_t> infos(samples_max);
  const dds_return_t count = dds_read(reader, samples.data(), infos.data(), samples_max, samples_max);
  for (std::size_t i = 0; i < static_cast<std::size_t>(std::max(count, 0)); ++i) {
    if (infos[i].valid_data && infos[i].instance_state == DDS_IST_ALIVE)
      use(*static_cast<const Sample*>(samples[i]));
  }
  if (count > 0) dds_return_loan(reader, samples.data(), count);
}

/// Returns a request of the reader that lists no writers, so that no samples are sent.
core::RecordBody request_of_nothing(const core::Request& request, std::uint64_t ahead) {
  core::Request nothing;
  nothing.reader = request.reader;
  nothing.sequence = std::min(request.sequence + ahead, core::request_sequence_max);
  return body_of(to_bytes(nothing));
}

}  // namespace

Forger::Forger()
    : self_(domain_0, interface, 0),
      publications_(dds_create_reader(self_.entity(), DDS_BUILTIN_TOPIC_DCPSPUBLICATION, nullptr, nullptr)) {}

Forger::~Forger() = default;

void Forger::look() {
  self_.take([this](const ControlParticipant::Came& came) {
    Known& known = known_[{came.participant, came.role, came.key}];
    if (came.record.revision >= known.record.revision) known = {came.writer, came.record};
  });
}

void Forger::withdraw_all() {
  look();
  for (const auto& [what, known] : known_) {
    const auto& [participant, role, key] = what;
    const sft_control_Record withdrawn =
        to_sample(participant, key, {.revision = known.record.revision + revisions_ahead});
    self_.dispose(role, withdrawn);
    self_.write_raw(role, withdrawn);
  }
}

void Forger::mute_all(std::uint64_t ahead) {
  look();
  if (!twin_) twin_ = std::make_unique<ControlParticipant>(domain_0, interface, made_up_process);
  for (const auto& [what, known] : known_) {
    const auto& [participant, role, key] = what;
    if (known.record.is_withdrawn()) continue;
    core::Record record{known.record.revision + ahead, known.record.body};
    if (key.kind == core::RecordKind::request) {
      const Result<core::Request> request = core::request_in(*record.body);
      if (!request) continue;
      record.body = request_of_nothing(*request, ahead);
      self_.write_raw(role, to_sample(participant, key, record));
    }
    if (role == core::Role::reader) twin_->write(role, key, record);
  }
  twin_->give_heartbeat();
}

void Forger::impersonate_processes() {
  look();
  for (const ControlParticipant::Other& other : self_.others()) {
    const auto data = core::parse_participant_data(other.user_data);
    if (!data || data->process == made_up_process) continue;
    std::unique_ptr<ControlParticipant>& impostor = impostors_[data->process];
    if (!impostor) impostor = std::make_unique<ControlParticipant>(domain_0, interface, data->process);
  }
  for (const auto& [process, impostor] : impostors_) {
    for (const auto& [what, known] : known_) {
      const auto& [participant, role, key] = what;
      impostor->write(role, key, {.revision = known.record.revision + revisions_ahead});
    }
    impostor->give_heartbeat();
  }
}

std::vector<dds_guid_t> Forger::writers_of(const std::string& topic) {
  constexpr std::size_t prefix = 12;
  std::set<std::array<std::uint8_t, 4>> entities;
  read_all<dds_builtintopic_endpoint_t>(publications_, [&](const dds_builtintopic_endpoint_t& writer) {
    if (writer.topic_name != topic) return;
    std::array<std::uint8_t, 4> entity{};
    std::copy_n(writer.key.v + prefix, entity.size(), entity.begin());
    entities.insert(entity);
  });
  std::vector<dds_guid_t> writers;
  for (const ControlParticipant::Other& other : self_.others()) {
    dds_guid_t writer = other.guid;
    for (const auto& entity : entities) {
      std::ranges::copy(entity, writer.v + prefix);
      writers.push_back(writer);
    }
  }
  return writers;
}

void Forger::outdate_announcements() {
  for (const char* topic : {"sft_writer", "sft_reader"}) {
    for (const dds_guid_t& writer : writers_of(topic)) {
      RtpsMessage message(writer);
      message.add_heartbeat(far_ahead);
      message.send();
    }
  }
}

void Forger::ask_for_nothing() {
  look();
  for (const auto& [what, known] : known_) {
    const auto& [participant, role, key] = what;
    if (key.kind != core::RecordKind::request || known.record.is_withdrawn()) continue;
    const Result<core::Request> request = core::request_in(*known.record.body);
    if (!request) continue;
    const core::Record nothing{known.record.revision + revisions_ahead,
                               request_of_nothing(*request, revisions_ahead)};
    RtpsMessage message(known.writer);
    message.add_heartbeat(far_ahead);
    message.add_record(far_ahead, to_sample(participant, key, nothing));
    message.send();
  }
}

void Forger::forge_heartbeats() {
  for (core::Heartbeat heartbeat : self_.overheard()) {
    for (const core::Role role : core::both_roles) heartbeat.digests[role] ^= 1;
    self_.send(heartbeat);
    ++heartbeat.process;
    self_.send(heartbeat);
    ++heartbeat.participant.back();
    self_.send(heartbeat);
  }
}

void Forger::outdate_heartbeats() {
  for (const ControlParticipant::Other& other : self_.others()) {
    for (const dds_guid_t& writer : guessed_writers(other.guid)) {
      RtpsMessage message(writer);
      message.add_data(far_ahead, std::string(core::heartbeat_bytes, '\0'));
      message.send();
    }
  }
}

void Forger::announce_version(unsigned version) {
  self_.set_user_data("sft/" + std::to_string(version) + "/0");
}

}  // namespace sft::test
