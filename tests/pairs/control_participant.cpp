#include "tests/pairs/control_participant.h"

#include <arpa/inet.h>
#include <net/if.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <span>
#include <stdexcept>
#include <utility>

#include "core/control/record_body.h"
#include "core/discovery/participant_data.h"

namespace sft::test {

namespace {

constexpr std::uint16_t heartbeat_port_of_domain_0 = 7404;

dds_entity_t checked(dds_entity_t entity) {
  if (entity < 0) throw std::runtime_error(std::string("Cyclone DDS: ") + dds_strretcode(entity));
  return entity;
}

struct QosDeleter {
  void operator()(dds_qos_t* qos) const { dds_delete_qos(qos); }
};
using Qos = std::unique_ptr<dds_qos_t, QosDeleter>;

/// Returns the QoS that nodes use for records (core/discovery/discovery.md).
Qos qos_of_records() {
  Qos qos(dds_create_qos());
  dds_qset_reliability(qos.get(), DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
  dds_qset_durability(qos.get(), DDS_DURABILITY_TRANSIENT_LOCAL);
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, 1);
  dds_qset_writer_data_lifecycle(qos.get(), false);
  dds_qset_ignorelocal(qos.get(), DDS_IGNORELOCAL_PARTICIPANT);
  return qos;
}

std::string user_data_of(const dds_qos_t* qos) {
  void* data = nullptr;
  std::size_t bytes = 0;
  if (!dds_qget_userdata(qos, &data, &bytes) || data == nullptr) return {};
  std::string text(static_cast<const char*>(data), bytes);
  dds_free(data);
  return text;
}

core::IpAddress address_of(const std::string& interface) {
  const int socket = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  ifreq request{};
  std::strncpy(request.ifr_name, interface.c_str(), sizeof request.ifr_name - 1);
  const int result = ioctl(socket, SIOCGIFADDR, &request);
  close(socket);
  if (result < 0) throw std::runtime_error("no address of " + interface);
  sockaddr_in address{};
  std::memcpy(&address, &request.ifr_addr, sizeof address);
  return core::IpAddress(ntohl(address.sin_addr.s_addr));
}

}  // namespace

ControlParticipant::ControlParticipant(dds_domainid_t domain, const std::string& interface,
                                       core::ProcessId process)
    : process_(process) {
  socket_ = core::HeartbeatSocket::open(
      {.ip = address_of(interface), .reaches_own_host = true, .index = if_nametoindex(interface.c_str())},
      heartbeat_port_of_domain_0);
  if (!socket_) throw std::runtime_error("no socket for heartbeats on " + interface);
  participant_ = checked(dds_create_participant(domain, nullptr, nullptr));
  dds_guid_t guid{};
  checked(dds_get_guid(participant_, &guid));
  std::ranges::copy(guid.v, guid_.begin());
  participants_ =
      checked(dds_create_reader(participant_, DDS_BUILTIN_TOPIC_DCPSPARTICIPANT, nullptr, nullptr));
  if (process != 0) set_user_data(to_text(core::ParticipantData{.process = process}));
  const Qos qos = qos_of_records();
  for (const core::Role role : core::both_roles) {
    const char* const name = role == core::Role::writer ? "sft_writer" : "sft_reader";
    const dds_entity_t topic =
        checked(dds_create_topic(participant_, &sft_control_Record_desc, name, qos.get(), nullptr));
    readers_[role] = checked(dds_create_reader(participant_, topic, qos.get(), nullptr));
    writers_[role] = checked(dds_create_writer(participant_, topic, qos.get(), nullptr));
  }
}

ControlParticipant::~ControlParticipant() { dds_delete(participant_); }

void ControlParticipant::take(const std::function<void(const Came&)>& use) {
  for (const core::Role role : core::both_roles) {
    for (;;) {
      void* taken = nullptr;
      dds_sample_info_t info{};
      if (dds_take(readers_[role], &taken, &info, 1, 1) <= 0) break;
      const auto& sample = *static_cast<const sft_control_Record*>(taken);
      dds_builtintopic_endpoint_t* const writer =
          info.valid_data ? dds_get_matched_publication_data(readers_[role], info.publication_handle)
                          : nullptr;
      if (writer != nullptr) {
        Came came{.role = role, .writer = writer->key};
        dds_builtintopic_free_endpoint(writer);
        std::ranges::copy(sample.participant, came.participant.begin());
        came.key = {sample.slot, static_cast<core::RecordKind>(sample.kind)};
        came.record.revision = sample.revision;
        const auto bytes = std::as_bytes(std::span(sample.body._buffer, sample.body._length));
        if (!bytes.empty()) came.record.body = body_of({bytes.begin(), bytes.end()});
        use(came);
      }
      dds_return_loan(readers_[role], &taken, 1);
    }
  }
}

void ControlParticipant::write(core::Role role, const core::RecordKey& key, core::Record record) {
  write_raw(role, to_sample(guid_, key, record));
  records_[role].put(key, std::move(record));
}

void ControlParticipant::write_raw(core::Role role, const sft_control_Record& sample) {
  dds_write(writers_[role], &sample);
}

void ControlParticipant::dispose(core::Role role, const sft_control_Record& key) {
  dds_dispose(writers_[role], &key);
}

void ControlParticipant::give_heartbeat() {
  send({guid_, process_, {records_.writer.digest(), records_.reader.digest()}});
}

void ControlParticipant::report(const core::NodeReport& report) {
  if (report_writer_ == 0) {
    const Qos qos(dds_create_qos());
    dds_qset_reliability(qos.get(), DDS_RELIABILITY_BEST_EFFORT, 0);
    const dds_entity_t topic =
        checked(dds_create_topic(participant_, &sft_control_Report_desc, "sft_report", qos.get(), nullptr));
    report_writer_ = checked(dds_create_writer(participant_, topic, qos.get(), nullptr));
  }
  std::vector<std::byte> body = to_bytes(report);
  const auto size = static_cast<std::uint32_t>(body.size());
  const sft_control_Report sample{.version = sft_control_protocol_version,
                                  .body = {size, size, reinterpret_cast<std::uint8_t*>(body.data()), false}};
  dds_write(report_writer_, &sample);
}

void ControlParticipant::send(const core::Heartbeat& heartbeat) {
  constexpr std::size_t remembered_max = 10'000;
  if (sent_.size() >= remembered_max) sent_.clear();
  sent_.insert(encode(heartbeat));
  socket_->send(heartbeat);
}

std::vector<core::Heartbeat> ControlParticipant::overheard() {
  std::vector<core::Heartbeat> heartbeats;
  socket_->take([&](const core::Heartbeat& heartbeat, auto, auto) {
    if (!sent_.contains(encode(heartbeat))) heartbeats.push_back(heartbeat);
  });
  return heartbeats;
}

std::vector<ControlParticipant::Other> ControlParticipant::others() const {
  constexpr std::size_t samples_max = 256;
  std::vector<void*> samples(samples_max);
  std::vector<dds_sample_info_t> infos(samples_max);
  std::vector<Other> others;
  const dds_return_t count = dds_read(participants_, samples.data(), infos.data(), samples_max, samples_max);
  for (std::size_t i = 0; i < static_cast<std::size_t>(std::max(count, 0)); ++i) {
    const auto& one = *static_cast<const dds_builtintopic_participant_t*>(samples[i]);
    const bool is_there = infos[i].valid_data && infos[i].instance_state == DDS_IST_ALIVE;
    if (is_there && std::memcmp(one.key.v, guid_.data(), guid_.size()) != 0)
      others.push_back({one.key, user_data_of(one.qos)});
  }
  if (count > 0) dds_return_loan(participants_, samples.data(), count);
  return others;
}

void ControlParticipant::set_user_data(const std::string& data) {
  const Qos qos(dds_create_qos());
  dds_qset_userdata(qos.get(), data.data(), data.size());
  checked(dds_set_qos(participant_, qos.get()));
}

sft_control_Record to_sample(const core::ParticipantGuid& participant, const core::RecordKey& key,
                             const core::Record& record) {
  sft_control_Record sample{};
  std::ranges::copy(participant, sample.participant);
  sample.slot = key.slot;
  sample.kind = static_cast<std::uint8_t>(key.kind);
  sample.version = sft_control_protocol_version;
  sample.revision = record.revision;
  if (record.is_withdrawn()) return sample;
  const auto size = static_cast<std::uint32_t>(record.body->size());
  auto* const octets = const_cast<std::byte*>(record.body->data());
  sample.body = {size, size, reinterpret_cast<std::uint8_t*>(octets), false};
  return sample;
}

core::RecordBody body_of(std::vector<std::byte> bytes) {
  return std::make_shared<const std::vector<std::byte>>(std::move(bytes));
}

}  // namespace sft::test
