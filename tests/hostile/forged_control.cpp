#include "tests/hostile/forged_control.h"

#include <dds/dds.h>

#include <algorithm>
#include <chrono>
#include <stdexcept>
#include <utility>

#include "tests/pairs/control_participant.h"

namespace sft::hostile {

namespace {

using Clock = std::chrono::steady_clock;

/// The settings for the loopback, where multicasts use separate ports.
constexpr const char* loopback_ports =
    "<Ports><MulticastMetaOffset>2</MulticastMetaOffset><MulticastDataOffset>3</MulticastDataOffset></Ports>";

}  // namespace

/// A Cyclone domain on one interface, which is domain 0 on the network.
class DomainOfLink {
 public:
  DomainOfLink(dds_domainid_t number, const std::string& interface) {
    const std::string config =
        "<CycloneDDS><Domain id=\"any\"><General><Interfaces><NetworkInterface name=\"" + interface +
        "\" multicast=\"true\"/></Interfaces></General><Discovery>"
        "<ExternalDomainId>0</ExternalDomainId>" +
        (interface == "lo" ? loopback_ports : "") + "</Discovery></Domain></CycloneDDS>";
    entity_ = dds_create_domain(number, config.c_str());
    if (entity_ < 0) throw std::runtime_error(std::string("Cyclone DDS: ") + dds_strretcode(entity_));
  }
  ~DomainOfLink() { dds_delete(entity_); }
  DomainOfLink(const DomainOfLink&) = delete;
  DomainOfLink& operator=(const DomainOfLink&) = delete;

 private:
  dds_entity_t entity_ = 0;
};

struct ForgedControl::Link {
  Link(dds_domainid_t number, const std::string& interface, core::ProcessId process)
      : domain(number, interface), participant(number, interface, process) {}
  DomainOfLink domain;
  test::ControlParticipant participant;
};

ForgedControl::ForgedControl(core::ProcessId process, const std::vector<std::string>& interfaces)
    : own_(process, core::Timing{}) {
  static dds_domainid_t domain = 0;
  for (const std::string& interface : interfaces)
    links_.push_back(std::make_unique<Link>(++domain, interface, process));
}

ForgedControl::~ForgedControl() = default;

/// Keeps a record of another participant. Withdrawn endpoints are kept, too, so that attacks on them
/// continue.
void ForgedControl::note(const test::ControlParticipant::Came& came) {
  auto& known = records_[{came.participant, came.role, came.key}];
  if (came.record.revision < known.record.revision) return;
  known = came;
  if (came.record.is_withdrawn()) return;
  if (came.key.kind == core::RecordKind::announcement) {
    if (auto endpoint = core::endpoint_in(*came.record.body)) heard_[endpoint->id] = std::move(*endpoint);
  } else if (came.key.kind == core::RecordKind::request) {
    if (auto request = core::request_in(*came.record.body)) requests_[request->reader] = std::move(*request);
  }
}

void ForgedControl::listen() {
  for (const auto& link : links_)
    link->participant.take([this](const test::ControlParticipant::Came& came) { note(came); });
}

std::vector<core::Endpoint> ForgedControl::heard() {
  listen();
  std::vector<core::Endpoint> all;
  for (const auto& [id, endpoint] : heard_) {
    const auto request = requests_.find(id);
    if (endpoint.role == core::Role::reader && request == requests_.end()) continue;
    core::Endpoint& one = all.emplace_back(endpoint);
    if (request != requests_.end()) one.request = request->second;
  }
  return all;
}

std::vector<core::Endpoint> ForgedControl::heard(core::Role role) {
  std::vector<core::Endpoint> found = heard();
  std::erase_if(found, [&](const core::Endpoint& endpoint) { return endpoint.role != role; });
  return found;
}

std::vector<ForgedControl::HeardRecord> ForgedControl::records_heard() {
  listen();
  std::vector<HeardRecord> heard;
  for (const auto& [of, came] : records_)
    heard.push_back({came.role, came.writer, test::to_sample(came.participant, came.key, came.record)});
  return heard;
}

std::vector<test::ControlParticipant::Other> ForgedControl::participants() const {
  return links_.back()->participant.others();
}

void ForgedControl::put(core::Role role, core::EndpointId id, core::RecordKind kind,
                        std::vector<std::byte> bytes) {
  const auto change = own_.put(role, id, kind, std::move(bytes), Clock::now());
  if (!change) return;
  for (const auto& link : links_) link->participant.write(role, change->key, change->record);
}

void ForgedControl::announce(const core::Endpoint& endpoint) {
  announce_bytes(endpoint.role, endpoint.id, core::to_bytes(endpoint));
  if (endpoint.role == core::Role::reader) request(endpoint.request);
}

void ForgedControl::request(const core::Request& request) {
  put(core::Role::reader, request.reader, core::RecordKind::request, core::to_bytes(request));
}

void ForgedControl::announce_bytes(core::Role role, core::EndpointId id, std::vector<std::byte> bytes) {
  put(role, id, core::RecordKind::announcement, std::move(bytes));
}

void ForgedControl::inquire(std::uint64_t owner, const core::Inquiry& inquiry) {
  put(core::Role::reader, owner, core::RecordKind::inquiry, core::to_bytes(inquiry));
}

void ForgedControl::report(const core::NodeReport& report) {
  for (const auto& link : links_) link->participant.report(report);
}

void ForgedControl::live() {
  const auto now = Clock::now();
  if (now < own_.heartbeat_due()) return;
  own_.heartbeat_given(now);
  for (const auto& link : links_) link->participant.give_heartbeat();
}

void ForgedControl::write_raw(core::Role role, const sft_control_Record& sample) {
  for (const auto& link : links_) link->participant.write_raw(role, sample);
}

void ForgedControl::write_as_own(core::Role role, sft_control_Record sample) {
  for (const auto& link : links_) {
    std::ranges::copy(link->participant.guid(), sample.participant);
    link->participant.write_raw(role, sample);
  }
}

void ForgedControl::dispose(core::Role role, const sft_control_Record& key) {
  for (const auto& link : links_) link->participant.dispose(role, key);
}

void ForgedControl::live(const core::PerRole<std::uint64_t>& digests) {
  for (const auto& link : links_) link->participant.send({link->participant.guid(), own_.process(), digests});
}

void ForgedControl::send(const core::Heartbeat& heartbeat) { links_.back()->participant.send(heartbeat); }

std::vector<core::Heartbeat> ForgedControl::overheard() { return links_.back()->participant.overheard(); }

core::Endpoint made_up_reader(const core::Endpoint& writer, std::uint64_t id, std::uint64_t node,
                              std::vector<core::UdpAddress> addresses) {
  core::Endpoint reader = writer;
  reader.id = id;
  reader.role = core::Role::reader;
  reader.node_id = node;
  reader.node = made_up;
  reader.host = {};
  reader.network = node;
  reader.may_use_memory = false;
  reader.addresses = std::move(addresses);
  reader.qos = {};
  reader.request = {};
  reader.request.reader = id;
  reader.request.sequence = 1;
  reader.request.mask_words = {~std::uint64_t{0}};
  reader.request.listening = {writer.id};
  return reader;
}

core::Endpoint made_up_writer(const core::Endpoint& reader, std::uint64_t id, std::uint64_t node) {
  core::Endpoint writer = reader;
  writer.id = id;
  writer.role = core::Role::writer;
  writer.node_id = node;
  writer.node = made_up;
  writer.host = {};
  writer.network = node;
  writer.may_use_memory = false;
  writer.addresses.clear();
  writer.max_sample_bytes = 1000;
  writer.request = {};
  return writer;
}

}  // namespace sft::hostile
