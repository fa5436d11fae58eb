#include "core/discovery/control_link.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <memory>
#include <span>

#include "core/control/record_body.h"
#include "core/discovery/dds_domain.h"
#include "core/discovery/known_peers.h"
#include "sft_control.h"

namespace sft::core {

namespace {

struct QosDeleter {
  void operator()(dds_qos_t* qos) const { dds_delete_qos(qos); }
};
using DdsQos = std::unique_ptr<dds_qos_t, QosDeleter>;

struct ListenerDeleter {
  void operator()(dds_listener_t* listener) const { dds_delete_listener(listener); }
};
using DdsListener = std::unique_ptr<dds_listener_t, ListenerDeleter>;

constexpr int heartbeats_kept = 16;
constexpr std::size_t writers_remembered = 4096;

ParticipantGuid guid_of(const dds_guid_t& guid) {
  ParticipantGuid octets{};
  std::ranges::copy(guid.v, octets.begin());
  return octets;
}

DdsQos qos_of(bool is_reliable) {
  DdsQos qos(dds_create_qos());
  dds_qset_reliability(qos.get(), is_reliable ? DDS_RELIABILITY_RELIABLE : DDS_RELIABILITY_BEST_EFFORT,
                       DDS_MSECS(100));
  dds_qset_durability(qos.get(), is_reliable ? DDS_DURABILITY_TRANSIENT_LOCAL : DDS_DURABILITY_VOLATILE);
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, is_reliable ? 1 : heartbeats_kept);
  // Missing heartbeats show that a process has ended, so its writers do not dispose of its records.
  dds_qset_writer_data_lifecycle(qos.get(), false);
  return qos;
}

DdsQos user_data_qos(const ParticipantData& data) {
  const std::string text = to_text(data);
  DdsQos qos(dds_create_qos());
  dds_qset_userdata(qos.get(), text.data(), text.size());
  return qos;
}

/// Takes all samples that a reader has, in batches, and calls `use(sample, info)` for each. Cyclone calls the
/// listener again for samples that come after the last batch.
template <class Sample, class Use>
void take_all(dds_entity_t reader, Use use) {
  constexpr std::size_t batch = 16;
  std::array<void*, batch> samples{};
  std::array<dds_sample_info_t, batch> infos{};
  for (;;) {
    const dds_return_t n = dds_take(reader, samples.data(), infos.data(), batch, batch);
    if (n <= 0) return;
    for (std::size_t i = 0; i < static_cast<std::size_t>(n); ++i)
      use(*static_cast<const Sample*>(samples[i]), infos[i]);
    dds_return_loan(reader, samples.data(), n);
    if (static_cast<std::size_t>(n) < batch) return;
    samples[0] = nullptr;
  }
}

/// The sample refers to the octets, which Cyclone only reads.
template <class Sample>
void set_body(Sample& sample, std::span<const std::byte> body) {
  const auto size = static_cast<std::uint32_t>(body.size());
  auto* const octets = const_cast<std::byte*>(body.data());
  sample.body = {size, size, reinterpret_cast<std::uint8_t*>(octets), false};
}

tl::unexpected<Error> refused(const char* what, dds_return_t status) {
  return fail(Errc::system, std::string(what) + ": " + dds_strretcode(status));
}

}  // namespace

ControlLink::ControlLink(const Place& place, KnownPeers& known)
    : place_(place),
      peers_(known),
      data_{.process = place.process, .is_secured = place.is_secured},
      records_{
          {.type = &sft_control_Record_desc,
           .name = "sft_writer",
           .is_reliable = true,
           .take = [](dds_entity_t reader, void* link) { of(link).take_records(reader, Role::writer); }},
          {.type = &sft_control_Record_desc,
           .name = "sft_reader",
           .is_reliable = true,
           .take = [](dds_entity_t reader, void* link) { of(link).take_records(reader, Role::reader); }}},
      heartbeats_{.type = &sft_control_HeartbeatSample_desc,
                  .name = "sft_heartbeat",
                  .take = [](dds_entity_t reader, void* link) { of(link).take_heartbeat_samples(reader); }},
      reports_{.type = &sft_control_Report_desc,
               .name = "sft_report",
               .take = [](dds_entity_t reader, void* link) { of(link).take_reports(reader); }} {}

ControlLink::~ControlLink() {
  if (participant_ > 0) dds_delete(participant_);  // Cyclone waits until running listeners have returned
}

Result<std::unique_ptr<ControlLink>> ControlLink::open(const Place& place, KnownPeers& known) {
  std::unique_ptr<ControlLink> link(new ControlLink(place, known));
  if (Result<void> opened = link->open(); !opened) return tl::unexpected(opened.error());
  return link;
}

Result<void> ControlLink::open() {
  if (place_.heartbeat_port) socket_ = HeartbeatSocket::open(place_.spec, *place_.heartbeat_port);
  data_.uses_topic = !socket_;
  const CycloneMessages messages;
  participant_ = dds_create_participant(place_.domain->id(), user_data_qos(data_).get(), nullptr);
  dds_guid_t guid{};
  if (participant_ < 0 || dds_get_guid(participant_, &guid) != DDS_RETCODE_OK)
    return fail(Errc::unavailable, "the DDS domain cannot be joined: " + messages.text() +
                                       "; check the network interfaces and CYCLONEDDS_URI");
  guid_ = guid_of(guid);
  const DdsListener listener(dds_create_listener(this));
  dds_lset_data_available(listener.get(),
                          [](dds_entity_t reader, void* link) { of(link).take_participants(reader); });
  const dds_entity_t reader =
      dds_create_reader(participant_, DDS_BUILTIN_TOPIC_DCPSPARTICIPANT, nullptr, listener.get());
  if (reader < 0) return refused("the participants cannot be watched", reader);
  return data_.uses_topic ? use_topic() : Result<void>();
}

/// Opens or closes the endpoints on the topic. Once the topic is created, it is kept, since a topic alone is
/// not announced to other participants. A reader gets no samples of its own participant.
Result<void> ControlLink::use(Topic& topic, bool reads, bool writes) {
  if (reads == (topic.reader != 0) && writes == (topic.writer != 0)) return {};
  const DdsQos qos = qos_of(topic.is_reliable);
  if (!writes && topic.writer != 0) dds_delete(std::exchange(topic.writer, 0));
  if (!reads && topic.reader != 0) dds_delete(std::exchange(topic.reader, 0));
  if (topic.topic == 0)
    topic.topic = dds_create_topic(participant_, topic.type, topic.name, qos.get(), nullptr);
  if (writes && topic.writer == 0)
    topic.writer = dds_create_writer(participant_, topic.topic, qos.get(), nullptr);
  if (reads && topic.reader == 0) {
    const DdsListener listener(dds_create_listener(this));
    dds_lset_data_available(listener.get(), topic.take);
    dds_qset_ignorelocal(qos.get(), DDS_IGNORELOCAL_PARTICIPANT);
    topic.reader = dds_create_reader(participant_, topic.topic, qos.get(), listener.get());
  }
  Result<void> result;
  for (dds_entity_t* const made : {&topic.topic, &topic.writer, &topic.reader}) {
    if (*made >= 0) continue;
    const dds_return_t status = std::exchange(*made, 0);
    if (result) result = refused((std::string("control topic ") + topic.name).c_str(), status);
  }
  return result;
}

Result<void> ControlLink::follow(const LinkUse& wanted) {
  Result<void> result = use(reports_, wanted.reads_reports, wanted.writes_reports);
  for (const Role role : both_roles) {
    Topic& topic = records_[role];
    if (Result<void> used = use(topic, wanted.reads_records[role], topic.writer != 0); !used) result = used;
  }
  return wants_topic_ && result ? use_topic() : result;
}

/// A write may block while other participants are slow to acknowledge earlier records. So after a failure
/// all further records are queued for write_again(), which is called once a second.
void ControlLink::write(Role role, const OwnRecords::Change& change) {
  if (unwritten_.empty() && try_to_write(role, change.key, change.record)) return;
  unwritten_.insert_or_assign({role, change.key}, change.record);
}

Result<void> ControlLink::write_again() {
  while (!unwritten_.empty()) {
    const auto& [what, record] = *unwritten_.begin();
    if (Result<void> written = try_to_write(what.first, what.second, record); !written) return written;
    unwritten_.erase(unwritten_.begin());
  }
  return {};
}

Result<void> ControlLink::try_to_write(Role role, const RecordKey& key, const Record& record) {
  Topic& topic = records_[role];
  if (Result<void> used = use(topic, topic.reader != 0, true); !used) return used;
  sft_control_Record sample{};
  std::ranges::copy(guid_, sample.participant);
  sample.slot = key.slot;
  sample.kind = static_cast<std::uint8_t>(key.kind);
  sample.version = static_cast<std::uint8_t>(control_protocol_version());
  sample.revision = record.revision;
  if (!record.is_withdrawn()) set_body(sample, *record.body);
  const dds_return_t status = dds_write(topic.writer, &sample);
  return status == DDS_RETCODE_OK ? Result<void>() : refused("a control record was not written", status);
}

void ControlLink::give_heartbeat(const PerRole<std::uint64_t>& digests) {
  const Heartbeat heartbeat{guid_, place_.process, digests};
  if (socket_) socket_->send(heartbeat);
  if (heartbeats_.writer == 0) return;
  sft_control_HeartbeatSample sample{};
  const HeartbeatDatagram datagram = encode(heartbeat);
  std::memcpy(sample.datagram, datagram.data(), datagram.size());
  dds_write(heartbeats_.writer, &sample);
}

void ControlLink::take_heartbeats(Time now) {
  if (socket_) {
    socket_->take([&](const Heartbeat& heartbeat, Time::duration age, const IpAddress& from) {
      peers_.heartbeat_came(place_.link, heartbeat, now, age, from);
    });
  }
}

Result<void> ControlLink::use_topic() {
  wants_topic_ = true;
  return use(heartbeats_, true, true).map([&] {
    if (!std::exchange(data_.uses_topic, true)) say_user_data();
  });
}

void ControlLink::give_report(std::span<const std::byte> body) {
  if (reports_.writer == 0) return;
  sft_control_Report sample{};
  sample.version = static_cast<std::uint8_t>(control_protocol_version());
  set_body(sample, body);
  dds_write(reports_.writer, &sample);
}

void ControlLink::announce(bool asks) {
  data_.asks = asks;
  say_user_data();
}

void ControlLink::say_user_data() {
  ++data_.count;
  dds_set_qos(participant_, user_data_qos(data_).get());
}

void ControlLink::flush(std::chrono::milliseconds timeout) {
  const auto end = std::chrono::steady_clock::now() + timeout;
  for (const Role role : both_roles) {
    const std::chrono::nanoseconds left = end - std::chrono::steady_clock::now();
    if (records_[role].writer != 0 && left.count() > 0)
      dds_wait_for_acks(records_[role].writer, left.count());
  }
}

void ControlLink::take_participants(dds_entity_t reader) {
  const Lock lock(taking_);
  take_all<dds_builtintopic_participant_t>(
      reader, [&](const dds_builtintopic_participant_t& sample, const dds_sample_info_t& info)
                  SFT_NO_THREAD_SAFETY_ANALYSIS { note_participant(sample, info); });
}

void ControlLink::note_participant(const dds_builtintopic_participant_t& sample,
                                   const dds_sample_info_t& info) {
  const ParticipantGuid guid = guid_of(sample.key);
  if (guid == guid_) return;
  if (info.instance_state != DDS_IST_ALIVE) {
    std::erase_if(writers_, [&](const auto& item) { return item.second == guid; });
    peers_.participant_gone(here(guid));
    return;
  }
  const std::string user_data = info.valid_data ? user_data_in(sample.qos) : "";
  if (const auto version = other_release(user_data)) peers_.other_release_seen(place_.link, *version);
  if (info.valid_data && !place_.is_secured && !is_of_sft(user_data)) peers_.vanilla_came(here(guid));
  const auto data = parse_participant_data(user_data);
  if (!data || data->is_secured != place_.is_secured) return;
  peers_.participant_came(here(guid), *data);
}

/// Returns the participant that the writer belongs to; nothing if the writer is gone and no sample of it was
/// taken before.
std::optional<ParticipantGuid> ControlLink::participant_of(dds_entity_t reader,
                                                           dds_instance_handle_t writer) {
  if (const auto found = writers_.find(writer); found != writers_.end()) return found->second;
  dds_builtintopic_endpoint_t* const matched = dds_get_matched_publication_data(reader, writer);
  if (matched == nullptr) return std::nullopt;
  const ParticipantGuid guid = guid_of(matched->participant_key);
  dds_builtintopic_free_endpoint(matched);
  if (writers_.size() >= writers_remembered)
    writers_.clear();  // writers that still exist are looked up again
  writers_.emplace(writer, guid);
  return guid;
}

/// Calls use(participant, sample) for each sample that the reader has. SFT neither disposes of samples nor
/// unregisters them: only forged samples do. So only samples with data are used.
template <class Sample, class Use>
void ControlLink::take(dds_entity_t reader, Use use) {
  const Lock lock(taking_);
  take_all<Sample>(reader,
                   [&](const Sample& sample, const dds_sample_info_t& info) SFT_NO_THREAD_SAFETY_ANALYSIS {
                     if (!info.valid_data) return;
                     if (const auto by = participant_of(reader, info.publication_handle)) use(*by, sample);
                   });
}

void ControlLink::take_records(dds_entity_t reader, Role role) {
  take<sft_control_Record>(reader, [&](const ParticipantGuid& by, const sft_control_Record& sample) {
    if (!std::ranges::equal(sample.participant, by))
      return peers_.sample_refused("a control record in the name of another participant");
    if (sample.version != control_protocol_version() ||
        sample.kind > static_cast<std::uint8_t>(RecordKind::inquiry))
      return peers_.sample_refused("a control record of an unknown kind or version");
    Record record{.revision = sample.revision};
    const auto* const first = reinterpret_cast<const std::byte*>(sample.body._buffer);
    if (sample.body._length > 0)
      record.body = std::make_shared<const std::vector<std::byte>>(first, first + sample.body._length);
    peers_.record_came(here(by), role, {sample.slot, static_cast<RecordKind>(sample.kind)},
                       std::move(record));
  });
}

void ControlLink::take_heartbeat_samples(dds_entity_t reader) {
  take<sft_control_HeartbeatSample>(
      reader, [&](const ParticipantGuid& by, const sft_control_HeartbeatSample& sample) {
        const auto heartbeat = decode_heartbeat(std::as_bytes(std::span(sample.datagram)));
        if (heartbeat && by == heartbeat->participant)
          peers_.heartbeat_came(place_.link, *heartbeat, std::chrono::steady_clock::now());
      });
}

void ControlLink::take_reports(dds_entity_t reader) {
  take<sft_control_Report>(reader, [&](const ParticipantGuid& by, const sft_control_Report& sample) {
    if (sample.version != control_protocol_version())
      return peers_.sample_refused("a report of an unknown version");
    Result<NodeReport> report = report_in(std::as_bytes(std::span(sample.body._buffer, sample.body._length)));
    if (!report) return peers_.sample_refused(report.error().message);
    peers_.report_came(here(by), std::move(*report));
  });
}

}  // namespace sft::core
