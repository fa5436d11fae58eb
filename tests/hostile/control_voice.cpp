#include "tests/hostile/control_voice.h"

#include <dds/dds.h>

#include <algorithm>
#include <array>
#include <functional>
#include <memory>
#include <stdexcept>

namespace sft::hostile {

namespace {

struct QosDeleter {
  void operator()(dds_qos_t* qos) const { dds_delete_qos(qos); }
};
using Qos = std::unique_ptr<dds_qos_t, QosDeleter>;

/// The QoS that matches what nodes use (core/negotiation/negotiation.md).
Qos lasting() {
  Qos qos(dds_create_qos());
  dds_qset_reliability(qos.get(), DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
  dds_qset_durability(qos.get(), DDS_DURABILITY_TRANSIENT_LOCAL);
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, 1);
  dds_qset_writer_data_lifecycle(qos.get(), false);
  dds_qset_ignorelocal(qos.get(), DDS_IGNORELOCAL_PARTICIPANT);
  return qos;
}

Qos passing() {
  Qos qos(dds_create_qos());
  dds_qset_reliability(qos.get(), DDS_RELIABILITY_BEST_EFFORT, 0);
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, 16);
  dds_qset_liveliness(qos.get(), DDS_LIVELINESS_MANUAL_BY_TOPIC, DDS_SECS(5));
  dds_qset_writer_data_lifecycle(qos.get(), false);
  dds_qset_ignorelocal(qos.get(), DDS_IGNORELOCAL_PARTICIPANT);
  return qos;
}

/// Multicasts of the loopback have ports of their own.
constexpr const char* loopback_ports =
    "<Ports><MulticastMetaOffset>2</MulticastMetaOffset><MulticastDataOffset>3</MulticastDataOffset></Ports>";

dds_entity_t sound(dds_entity_t entity) {
  if (entity < 0) throw std::runtime_error(std::string("Cyclone DDS: ") + dds_strretcode(entity));
  return entity;
}

template <class Sample, class Use>
void take_all(dds_entity_t reader, Use use) {
  std::array<void*, 1> sample{};
  dds_sample_info_t info{};
  while (dds_take(reader, sample.data(), &info, 1, 1) == 1) {
    use(*static_cast<const Sample*>(sample[0]), info);
    dds_return_loan(reader, sample.data(), 1);
    sample[0] = nullptr;
  }
}

}  // namespace

/// One interface, in a Cyclone domain of its own that is domain 0 on the wire.
class ControlVoice::Link {
 public:
  Link(dds_domainid_t domain, const std::string& interface) {
    const std::string config =
        "<CycloneDDS><Domain id=\"any\"><General><Interfaces><NetworkInterface name=\"" + interface +
        "\" multicast=\"true\"/></Interfaces></General><Discovery>"
        "<ExternalDomainId>0</ExternalDomainId>" +
        (interface == "lo" ? loopback_ports : "") + "</Discovery></Domain></CycloneDDS>";
    domain_ = sound(dds_create_domain(domain, config.c_str()));
    const dds_entity_t participant = sound(dds_create_participant(domain, nullptr, nullptr));
    const Qos control = lasting();
    const Qos life = passing();
    const auto topic = [&](const dds_topic_descriptor_t& type, const char* name, const Qos& qos) {
      return sound(dds_create_topic(participant, &type, name, qos.get(), nullptr));
    };
    const dds_entity_t writers = topic(sft_control_Endpoint_desc, "sft_writer", control);
    const dds_entity_t readers = topic(sft_control_ReaderWord_desc, "sft_reader", control);
    const dds_entity_t lives = topic(sft_control_Assertion_desc, "sft_liveliness", life);
    hears_writers = sound(dds_create_reader(participant, writers, control.get(), nullptr));
    hears_readers = sound(dds_create_reader(participant, readers, control.get(), nullptr));
    tells_of_writers = sound(dds_create_writer(participant, writers, control.get(), nullptr));
    tells_of_readers = sound(dds_create_writer(participant, readers, control.get(), nullptr));
    life_writer = sound(dds_create_writer(participant, lives, life.get(), nullptr));
  }
  ~Link() { dds_delete(domain_); }
  Link(const Link&) = delete;
  Link& operator=(const Link&) = delete;

  void listen(std::map<core::EndpointId, core::Endpoint>& heard) {
    take_all<sft_control_Endpoint>(hears_writers,
                                   [&](const sft_control_Endpoint& sample, const dds_sample_info_t& info) {
                                     if (!info.valid_data) return;
                                     keys_[sample.id] = sample.instance;
                                     if (auto endpoint = core::from_dds(sample))
                                       heard[sample.id] = std::move(*endpoint);
                                   });
    take_all<sft_control_ReaderWord>(
        hears_readers, [&](const sft_control_ReaderWord& word, const dds_sample_info_t& info) {
          if (!info.valid_data) return;
          auto said = core::from_dds(word);
          if (!said) return;
          if (auto* const announced = std::get_if<core::Endpoint>(&*said)) {
            keys_[announced->id] = word.instance;
            heard[announced->id] = std::move(*announced);
            return;
          }
          auto& request = std::get<core::Request>(*said);
          keys_[request.reader] = word.instance;
          if (const auto reader = heard.find(request.reader); reader != heard.end())
            reader->second.request = std::move(request);
        });
  }

  /// Returns the key that the endpoint has on this link. An endpoint that this test announces has its id as
  /// key.
  std::uint64_t key_of(core::EndpointId id) const {
    const auto heard = keys_.find(id);
    return heard == keys_.end() ? id : heard->second;
  }

  dds_entity_t hears_writers = 0, hears_readers = 0;
  dds_entity_t tells_of_writers = 0, tells_of_readers = 0;
  dds_entity_t life_writer = 0;

 private:
  dds_entity_t domain_ = 0;
  std::map<core::EndpointId, std::uint64_t> keys_;
};

ControlVoice::ControlVoice() {
  dds_domainid_t domain = 1;
  for (const char* interface : {"lo", "eth0"}) links_.push_back(std::make_unique<Link>(domain++, interface));
}

ControlVoice::~ControlVoice() = default;

std::vector<core::Endpoint> ControlVoice::heard() {
  for (const auto& link : links_) link->listen(heard_);
  std::vector<core::Endpoint> all;
  for (const auto& [id, endpoint] : heard_) all.push_back(endpoint);
  return all;
}

std::vector<core::Endpoint> ControlVoice::heard(core::Role role) {
  std::vector<core::Endpoint> found = heard();
  std::erase_if(found, [&](const core::Endpoint& endpoint) { return endpoint.role != role; });
  return found;
}

void ControlVoice::announce(const core::Endpoint& endpoint) {
  core::ControlStorage storage;
  announce_raw(core::to_dds(endpoint, storage));
}

void ControlVoice::announce_raw(const sft_control_Endpoint& endpoint) {
  const bool is_writer = endpoint.role == static_cast<std::uint8_t>(core::Role::writer);
  sft_control_Endpoint copy = endpoint;
  for (const auto& link : links_) {
    copy.instance = link->key_of(endpoint.id);
    const sft_control_ReaderWord word = core::in_word(copy);
    is_writer ? dds_write(link->tells_of_writers, &copy) : dds_write(link->tells_of_readers, &word);
  }
}

void ControlVoice::request(const core::Request& request) {
  core::ControlStorage storage;
  sft_control_Request sample = core::to_dds(request, storage);
  for (const auto& link : links_) {
    const sft_control_ReaderWord word = core::in_word(sample, link->key_of(request.reader));
    dds_write(link->tells_of_readers, &word);
  }
}

void ControlVoice::dispose(core::EndpointId endpoint) {
  for (const auto& link : links_) {
    sft_control_Endpoint key{};
    sft_control_ReaderWord reader_key{};
    key.instance = reader_key.instance = link->key_of(endpoint);
    dds_dispose(link->tells_of_writers, &key);
    dds_dispose(link->tells_of_readers, &reader_key);
  }
}

void ControlVoice::unregister(core::EndpointId endpoint) {
  for (const auto& link : links_) {
    sft_control_Endpoint key{};
    sft_control_ReaderWord reader_key{};
    key.instance = reader_key.instance = link->key_of(endpoint);
    dds_unregister_instance(link->tells_of_writers, &key);
    dds_unregister_instance(link->tells_of_readers, &reader_key);
  }
}

void ControlVoice::assert_life(core::NodeId node, const std::vector<core::EndpointId>& writers,
                               const std::vector<core::Progress>& progress) {
  assert_life(core::Assertion{node, writers, progress});
}

void ControlVoice::assert_life(const core::Assertion& assertion) {
  core::ControlStorage storage;
  const sft_control_Assertion sample = core::to_dds(assertion, storage);
  for (const auto& link : links_) dds_write(link->life_writer, &sample);
}

void ControlVoice::dispose_life(core::NodeId node) {
  sft_control_Assertion key{};
  key.node = node;
  for (const auto& link : links_) dds_dispose(link->life_writer, &key);
}

core::Endpoint made_up_reader(const core::Endpoint& writer, std::uint64_t id, std::uint64_t node,
                              std::vector<core::UdpAddress> addresses) {
  core::Endpoint reader = writer;
  reader.id = id;
  reader.role = core::Role::reader;
  reader.node_id = node;
  reader.node = made_up;
  reader.revision = 1;
  reader.life_lease = std::chrono::minutes(10);
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
  writer.revision = 1;
  writer.life_lease = std::chrono::minutes(10);
  writer.host = {};
  writer.network = node;
  writer.may_use_memory = false;
  writer.addresses.clear();
  writer.max_sample_bytes = 1000;
  writer.request = {};
  return writer;
}

}  // namespace sft::hostile
