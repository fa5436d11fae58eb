#include "tests/pairs/forger.h"

#include <arpa/inet.h>
#include <net/if.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <set>
#include <stdexcept>
#include <string>

#include "core/control/control_codec.h"
#include "core/discovery/participant_mark.h"
#include "tests/support/eventually.h"

namespace sft::test {

namespace {

dds_entity_t checked(dds_entity_t entity) {
  if (entity < 0) throw std::runtime_error(std::string("forger: ") + dds_strretcode(entity));
  return entity;
}

template <class Sample, class Use>
void take_all(dds_entity_t reader, Use use) {
  for (;;) {
    void* sample = nullptr;
    dds_sample_info_t info;
    if (dds_take(reader, &sample, &info, 1, 1) <= 0) return;
    if (info.valid_data) use(*static_cast<const Sample*>(sample), info);
    dds_return_loan(reader, &sample, 1);
  }
}

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

/// RTPS 2.1, little endian.
class RtpsMessage {
 public:
  explicit RtpsMessage(const dds_guid_t& sender) {
    bytes_ = "RTPS";
    bytes_.append("\x02\x01\x01\x10", 4);  // version, vendor
    bytes_.append(reinterpret_cast<const char*>(sender.v), 12);
    writer_.assign(reinterpret_cast<const char*>(sender.v) + 12, 4);
  }
  void add(std::uint16_t number) { add(&number, sizeof number); }
  void add(std::uint32_t number) { add(&number, sizeof number); }
  void add_sequence(std::uint64_t number) {
    add(static_cast<std::uint32_t>(number >> 32));
    add(static_cast<std::uint32_t>(number));
  }
  /// Addresses the submessage to any reader.
  void add_entities() { bytes_ += std::string(4, '\0') + writer_; }
  void add_submessage(char kind, char flags, std::uint16_t length) {
    bytes_ += {kind, flags};
    add(length);
  }
  /// Sends the message to everybody who listens to the user data of domain 0.
  void add_text(const std::string& bytes) { bytes_ += bytes; }
  void send() const {
    const int socket = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(7401);
    to.sin_addr.s_addr = inet_addr("239.255.0.1");
    ip_mreqn interface {};
    interface.imr_ifindex = static_cast<int>(if_nametoindex("eth0"));
    setsockopt(socket, IPPROTO_IP, IP_MULTICAST_IF, &interface, sizeof interface);
    const ssize_t sent =
        sendto(socket, bytes_.data(), bytes_.size(), 0, reinterpret_cast<const sockaddr*>(&to), sizeof to);
    close(socket);
    if (sent < 0) throw std::runtime_error(std::string("forger: ") + std::strerror(errno));
  }

 private:
  void add(const void* data, std::size_t bytes) { bytes_.append(static_cast<const char*>(data), bytes); }

  std::string bytes_;
  std::string writer_;
};

constexpr std::uint64_t far_ahead = std::uint64_t{1} << 40;
constexpr char data_kind = 0x15, heartbeat_kind = 0x07;

/// Adds a sample, which goes to the end of the message.
void add_data(RtpsMessage& message, const std::string& sample) {
  const std::uint16_t to_sequence = 16;
  message.add_submessage(data_kind, 0x05, 0);
  message.add(std::uint16_t{0});
  message.add(to_sequence);
  message.add_entities();
  message.add_sequence(far_ahead);
  message.add_text(std::string("\x00\x01\x00\x00", 4) + sample);  // little endian
}

void send_data_far_ahead(const dds_guid_t& writer) {
  RtpsMessage message(writer);
  constexpr std::size_t sign_of_life_bytes = 16;
  std::string sample(sign_of_life_bytes, '\0');
  sample[0] = 1;  // some node
  sample[8] = static_cast<char>(sft_control_protocol_version);
  add_data(message, sample);
  message.send();
}

void add_heartbeat(RtpsMessage& message) {
  message.add_submessage(heartbeat_kind, 0x01, 28);
  message.add_entities();
  message.add_sequence(far_ahead);
  message.add_sequence(far_ahead);
  message.add(std::uint32_t{0x0700'0000});  // how many heartbeats came before
}

void send_heartbeat_far_ahead(const dds_guid_t& writer) {
  RtpsMessage message(writer);
  add_heartbeat(message);
  message.send();
}

/// Says in the writer's name that the reader listens to nobody.
void send_empty_request(const dds_guid_t& writer, std::uint64_t key, std::uint64_t reader,
                        std::uint64_t sequence) {
  constexpr std::size_t request_begins = 24, request_bytes = 44;
  std::string sample(request_begins + request_bytes, '\0');
  std::memcpy(sample.data(), &key, sizeof key);
  sample[8] = static_cast<char>(core::ReaderPart::request);
  sample[16] = 1;  // so many requests, in little endian
  std::memcpy(sample.data() + request_begins, &reader, sizeof reader);
  sample[request_begins + 8] = static_cast<char>(sft_control_protocol_version);
  std::memcpy(sample.data() + request_begins + 16, &sequence, sizeof sequence);
  RtpsMessage message(writer);
  add_heartbeat(message);
  add_data(message, sample);
  message.send();
}

}  // namespace

Forger::Forger() : participant_(checked(dds_create_participant(0, nullptr, nullptr))) {
  dds_qos_t* const qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_MSECS(100));
  dds_qset_durability(qos, DDS_DURABILITY_TRANSIENT_LOCAL);
  dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 1);
  dds_qset_writer_data_lifecycle(qos, false);
  dds_qset_ignorelocal(qos, DDS_IGNORELOCAL_PARTICIPANT);
  const auto topic = [&](const dds_topic_descriptor_t& type, const char* name) {
    return checked(dds_create_topic(participant_, &type, name, qos, nullptr));
  };
  const auto join = [&](const dds_topic_descriptor_t& type, const char* name) {
    const dds_entity_t joined = topic(type, name);
    return Words{checked(dds_create_reader(participant_, joined, qos, nullptr)),
                 checked(dds_create_writer(participant_, joined, qos, nullptr))};
  };
  of_writers_ = join(sft_control_Endpoint_desc, "sft_writer");
  of_readers_ = join(sft_control_ReaderWord_desc, "sft_reader");
  dds_delete_qos(qos);
  participants_ =
      checked(dds_create_reader(participant_, DDS_BUILTIN_TOPIC_DCPSPARTICIPANT, nullptr, nullptr));
  publications_ =
      checked(dds_create_reader(participant_, DDS_BUILTIN_TOPIC_DCPSPUBLICATION, nullptr, nullptr));
}

void Forger::look() {
  const auto note = [this](std::uint64_t id, std::uint64_t key, std::uint64_t sequence) {
    known_[id] = std::max(known_[id], sequence);
    keys_[id] = key;
  };
  take_all<sft_control_Endpoint>(of_writers_.reader,
                                 [&](const sft_control_Endpoint& endpoint, const dds_sample_info_t& info) {
                                   if (info.valid_data) note(endpoint.id, endpoint.instance, 0);
                                 });
  take_all<sft_control_ReaderWord>(
      of_readers_.reader, [&](const sft_control_ReaderWord& word, const dds_sample_info_t& info) {
        if (word.announcement._length == 1) {
          const sft_control_Endpoint& reader = *word.announcement._buffer;
          note(reader.id, word.instance, reader.request.request_sequence);
        }
        if (word.request._length == 0) return;
        const sft_control_Request& request = *word.request._buffer;
        note(request.reader, word.instance, request.request_sequence);
        dds_builtintopic_endpoint_t* const writer =
            dds_get_matched_publication_data(of_readers_.reader, info.publication_handle);
        if (writer == nullptr) return;
        asks_by_[request.reader] = writer->key;
        dds_builtintopic_free_endpoint(writer);
      });
}

void Forger::withdraw_all() {
  look();
  for (const auto& [id, sequence] : known_) {
    sft_control_Endpoint writer{};
    writer.instance = keys_[id];
    sft_control_ReaderWord reader{};
    reader.instance = keys_[id];
    checked(sequence == 0 ? dds_dispose(of_writers_.writer, &writer)
                          : dds_dispose(of_readers_.writer, &reader));
  }
}

void Forger::mute_all(std::uint64_t ahead) {
  look();
  for (const auto& [id, sequence] : known_) {
    if (sequence == 0) continue;
    sft_control_Request request{};
    request.reader = id;
    request.version = sft_control_protocol_version;
    request.request_sequence = sequence + ahead;
    const sft_control_ReaderWord word = core::in_word(request, keys_[id]);
    checked(dds_write(of_readers_.writer, &word));
  }
}

std::vector<dds_guid_t> Forger::participants_of_others() {
  dds_guid_t own{};
  checked(dds_get_guid(participant_, &own));
  std::vector<dds_guid_t> participants;
  read_all<dds_builtintopic_participant_t>(participants_, [&](const dds_builtintopic_participant_t& one) {
    if (std::memcmp(one.key.v, own.v, sizeof own.v) != 0) participants.push_back(one.key);
  });
  return participants;
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
  for (dds_guid_t writer : participants_of_others()) {
    for (const auto& entity : entities) {
      std::ranges::copy(entity, writer.v + prefix);
      writers.push_back(writer);
    }
  }
  return writers;
}

/// Nodes make these writers when they have met.
void Forger::outdate_signs_of_life() {
  std::vector<dds_guid_t> writers;
  const auto are_there = [&] { return !(writers = writers_of("sft_liveliness")).empty(); };
  if (!test::eventually(are_there)) throw std::runtime_error("forger: nobody gives full signs of life");
  for (const dds_guid_t& writer : writers) send_data_far_ahead(writer);
}

void Forger::forge_pulses() {
  if (!pulses_) {
    const std::uint16_t port_of_domain_0 = 7404;
    pulses_ = core::PulseSocket::open(
        {.ip = {}, .index = if_nametoindex("eth0"), .port = port_of_domain_0, .reaches_own_host = false});
    if (!pulses_) throw std::runtime_error("forger: no socket for pulses");
  }
  std::vector<core::Pulse> overheard;
  pulses_->take([&](const core::Pulse& pulse) { overheard.push_back(pulse); });
  for (core::Pulse pulse : overheard) {
    pulse.digest_of_writers ^= 1;
    pulse.digest_of_readers ^= 1;
    pulse.full_signs += 100;
    pulses_->send(pulse);
    ++pulse.node;
    pulses_->send(pulse);
  }
}

void Forger::outdate_announcements() {
  for (const char* topic : {"sft_writer", "sft_reader"}) {
    for (const dds_guid_t& writer : writers_of(topic)) send_heartbeat_far_ahead(writer);
  }
}

void Forger::ask_for_nothing() {
  look();
  for (const auto& [reader, writer] : asks_by_)
    send_empty_request(writer, keys_[reader], reader, known_[reader] + 1000);
}

void Forger::complain_of_all() {
  core::ParticipantMark mark{.greeting = ++complaints_};
  for (const dds_guid_t& participant : participants_of_others()) {
    if (mark.complaints.size() == core::complaints_max) break;
    std::ranges::copy(participant.v, mark.complaints.emplace_back().begin());
  }
  set_user_data(to_text(mark));
}

void Forger::claim_version(unsigned version) { set_user_data("sft/" + std::to_string(version) + "/0"); }

void Forger::set_user_data(const std::string& data) {
  dds_qos_t* const qos = dds_create_qos();
  dds_qset_userdata(qos, data.data(), data.size());
  checked(dds_set_qos(participant_, qos));
  dds_delete_qos(qos);
}

}  // namespace sft::test
