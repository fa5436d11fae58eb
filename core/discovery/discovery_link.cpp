#include "core/discovery/discovery_link.h"

#include <dds/dds.h>

#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "core/control/control_codec.h"
#include "core/discovery/control_qos.h"
#include "core/discovery/control_topic.h"
#include "core/discovery/dds_domain.h"
#include "core/discovery/own_keys.h"
#include "core/discovery/participant_mark.h"
#include "core/discovery/take_all.h"
#include "core/discovery/topic_endpoint.h"

namespace sft::core {

namespace {

constexpr ControlTopic::Kind kind_of_writers{{&sft_control_Endpoint_desc, "sft_writer"}, &take_writers};
constexpr ControlTopic::Kind kind_of_readers{{&sft_control_ReaderWord_desc, "sft_reader"}, &take_readers};
constexpr ControlTopic::Kind kind_of_lives{{&sft_control_Assertion_desc, "sft_liveliness"}, &take_assertions};

class CycloneLink final : public DiscoveryLink {
 public:
  CycloneLink(const Place& place, Participants& participants, LinkListener& listener)
      : place_(place),
        participants_(participants),
        listener_(listener),
        mark_{.is_secured = place.is_secured} {}

  ~CycloneLink() override {
    if (participant_ > 0) dds_delete(participant_);  // Cyclone waits for listeners that run
  }

  Result<void> open(const LifeSigns& signs) {
    if (place_.pulses) pulses_ = PulseSocket::open(*place_.pulses);
    const CycloneMessages messages;
    participant_ = dds_create_participant(domain(), participant_qos(mark_).get(), nullptr);
    dds_guid_t guid{};
    if (participant_ < 0 || dds_get_guid(participant_, &guid) != DDS_RETCODE_OK) {
      return fail(Errc::unavailable, "the DDS domain cannot be joined: " + messages.text() +
                                         "; check the network interfaces and CYCLONEDDS_URI");
    }
    guid_ = to_guid(guid);
    participants_.add_own(guid_);
    const auto topic = [&](std::optional<ControlTopic>& made, const ControlTopic::Kind& kind, DdsQos qos) {
      made.emplace(participant_, kind, std::move(qos), [this](const ControlWord& word) { heard(word); });
    };
    topic(writers_, kind_of_writers, control_qos());
    topic(readers_, kind_of_readers, control_qos());
    topic(lives_, kind_of_lives, assertion_qos(pulses_ ? full_sign_lease : signs.lease));
    return watch_participants();
  }

  Result<void> hear(Role role) override { return topic_of(role).hear(); }
  Result<void> exchange_full_signs() override {
    return lives_->hear().and_then([this] { return lives_->writer().map([](dds_entity_t) {}); });
  }
  Result<void> write(const Endpoint& endpoint) override {
    ControlStorage storage;
    sft_control_Endpoint sample = to_dds(endpoint, storage);
    sample.instance = keys_.key_of(endpoint.id);
    if (endpoint.role == Role::writer) return write_to(*writers_, &sample);
    const sft_control_ReaderWord word = in_word(sample);
    return write_to(*readers_, &word);
  }
  Result<void> write(const Request& request) override {
    ControlStorage storage;
    sft_control_Request sample = to_dds(request, storage);
    const sft_control_ReaderWord word = in_word(sample, keys_.key_of(request.reader));
    return write_to(*readers_, &word);
  }
  void write(const Assertion& assertion, bool is_full) override {
    if (pulses_) {
      pulses_->send({.node = assertion.node,
                     .participant = Participants::tag_of(guid_),
                     .digest_of_writers = assertion.digest_of_writers,
                     .digest_of_readers = assertion.digest_of_readers,
                     .full_signs = full_signs_});
      if (!is_full || lives_->known_writer() == 0) return;
      ++full_signs_;  // the next pulse says so: this one may be heard before the full sign
    }
    ControlStorage storage;
    const sft_control_Assertion sample = to_dds(assertion, storage);
    dds_write(lives_->known_writer(), &sample);
  }
  bool hear_pulses(Time since) override {
    bool all_count = true;
    if (!pulses_) return all_count;
    pulses_->take([&](const Pulse& pulse) {
      all_count &= listener_.pulse_came(place_.link, pulse, participants_, since);
    });
    return all_count;
  }
  void dispose(EndpointId id, Role role) override {
    const dds_entity_t writer = topic_of(role).known_writer();
    const std::optional<std::uint64_t> number = keys_.release(id);
    if (writer == 0 || !number) return;
    if (role == Role::writer) {
      sft_control_Endpoint key{};
      key.instance = *number;
      dds_dispose(writer, &key);
      dds_unregister_instance(writer, &key);
      return;
    }
    sft_control_ReaderWord key{};
    key.instance = *number;
    key.part = static_cast<std::uint8_t>(ReaderPart::announcement);
    dds_dispose(writer, &key);
    dds_unregister_instance(writer, &key);
    key.part = static_cast<std::uint8_t>(ReaderPart::request);
    dds_unregister_instance(writer, &key);
  }
  void end_life(NodeId node) override {
    sft_control_Assertion key{};
    key.node = node;
    if (lives_->known_writer() != 0) dds_unregister_instance(lives_->known_writer(), &key);
  }
  void greet() override {
    ++mark_.greeting;
    dds_set_qos(participant_, participant_qos(mark_).get());
  }
  void complain(const std::vector<AnnouncerId>& participants) override {
    mark_.complaints.clear();
    for (const AnnouncerId participant : participants) {
      if (const auto guid = participants_.guid_of(participant)) mark_.complaints.push_back(*guid);
    }
    greet();
  }
  void flush(std::chrono::milliseconds patience) override {
    const auto end = std::chrono::steady_clock::now() + patience;
    for (const Role role : {Role::writer, Role::reader}) {
      const dds_entity_t writer = topic_of(role).known_writer();
      const std::chrono::nanoseconds left = end - std::chrono::steady_clock::now();
      if (writer != 0 && left.count() > 0) dds_wait_for_acks(writer, left.count());
    }
  }

 private:
  dds_domainid_t domain() const { return place_.domain == nullptr ? place_.number : place_.domain->id(); }

  ControlTopic& topic_of(Role role) { return role == Role::writer ? *writers_ : *readers_; }

  static Result<void> write_to(ControlTopic& topic, const void* sample) {
    const Result<dds_entity_t> writer = topic.writer();
    if (!writer) return tl::unexpected(writer.error());
    const dds_return_t status = dds_write(*writer, sample);
    if (status == DDS_RETCODE_OK) return {};
    return fail(Errc::system, std::string("a control sample was not written: ") + dds_strretcode(status));
  }

  Result<void> watch_participants() {
    const DdsListener listener(dds_create_listener(this));
    dds_lset_data_available(listener.get(), &on_participants);
    const dds_entity_t reader =
        dds_create_reader(participant_, DDS_BUILTIN_TOPIC_DCPSPARTICIPANT, nullptr, listener.get());
    if (reader >= 0) return {};
    return fail(Errc::system, std::string("the participants cannot be watched: ") + dds_strretcode(reader));
  }

  /// A word of this process itself, on this link or another, does not count.
  void heard(const ControlWord& word) {
    Speaker speaker{place_.link, 0};
    if (word.speaker) {
      if (participants_.is_own(*word.speaker)) return;
      speaker.participant = participants_.number_of(*word.speaker);
    }
    std::visit([&](const auto& what) { told(speaker, what); }, word.what);
  }
  void told(const Speaker& speaker, const Endpoint& endpoint) { listener_.endpoint_came(speaker, endpoint); }
  void told(const Speaker& speaker, const Request& request) { listener_.request_came(speaker, request); }
  void told(const Speaker& speaker, const EndpointWithdrawn& withdrawn) {
    listener_.endpoint_withdrawn(speaker, withdrawn.id);
  }
  void told(const Speaker&, const EndpointUnheard& unheard) {
    listener_.endpoint_unheard(place_.link, unheard.id);
  }
  void told(const Speaker& speaker, const SignOfLife& sign) {
    listener_.assertion_came(speaker, sign.assertion, sign.lease);
  }
  void told(const Speaker&, const NodeUnheard& unheard) { listener_.node_unheard(place_.link, unheard.id); }
  void told(const Speaker& speaker, const EndpointMet&) { listener_.endpoint_matched(speaker, true); }
  void told(const Speaker& speaker, const EndpointGone&) { listener_.endpoint_matched(speaker, false); }
  void told(const Speaker&, const SampleMalformed& malformed) { listener_.sample_malformed(malformed.why); }

  static void on_participants(dds_entity_t reader, void* self) {
    CycloneLink& link = *static_cast<CycloneLink*>(self);
    take_all<dds_builtintopic_participant_t>(
        reader, [&](const dds_builtintopic_participant_t& sample, const dds_sample_info_t& info) {
          link.participant_said(sample, info);
        });
  }

  void participant_said(const dds_builtintopic_participant_t& sample, const dds_sample_info_t& info) {
    const Participants::Guid guid = to_guid(sample.key);
    if (participants_.is_own(guid)) return;
    const Speaker speaker{place_.link, participants_.number_of(guid)};
    if (info.instance_state != DDS_IST_ALIVE) {
      participants_.gone(guid);
      for (auto* const topic : {&writers_, &readers_, &lives_}) (*topic)->forget(guid);
      listener_.participant_departed(speaker);
      return;
    }
    const std::string user_data = info.valid_data ? user_data_of(sample.qos) : "";
    const auto mark = parse_participant_mark(user_data);
    if (info.view_state == DDS_VST_NEW) listener_.participant_came(speaker);
    if (const auto version = other_version(user_data)) listener_.other_release_seen(speaker, *version);
    if (!mark || mark->is_secured != place_.is_secured) return;
    listener_.participant_speaks(speaker);
    if (std::ranges::find(mark->complaints, guid_) != mark->complaints.end())
      listener_.complaint_came(speaker);
  }

  const Place place_;
  Participants& participants_;
  LinkListener& listener_;
  ParticipantMark mark_;
  OwnKeys keys_;
  Participants::Guid guid_{};  ///< of the participant
  std::optional<PulseSocket> pulses_;
  std::uint8_t full_signs_ = 0;
  dds_entity_t participant_ = 0;
  /// All of them are there once the link is open.
  std::optional<ControlTopic> writers_, readers_, lives_;
};

}  // namespace

Result<std::unique_ptr<DiscoveryLink>> DiscoveryLink::open(const Place& place, const LifeSigns& signs,
                                                           Participants& participants,
                                                           LinkListener& listener) {
  auto link = std::make_unique<CycloneLink>(place, participants, listener);
  if (Result<void> opened = link->open(signs); !opened) return tl::unexpected(opened.error());
  return link;
}

}  // namespace sft::core
