#include "core/discovery/discovery_link.h"

#include <dds/dds.h>

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>

#include "core/control/control_codec.h"
#include "core/discovery/control_qos.h"
#include "core/discovery/control_topic.h"
#include "core/discovery/dds_domain.h"
#include "core/discovery/participant_mark.h"
#include "core/discovery/remote_endpoints.h"

namespace sft::core {

namespace {

/// Takes all that a reader has, in batches, and calls `use(sample, info)`.
template <class Sample, class Use>
void take_all(dds_entity_t reader, Use use) {
  constexpr std::size_t batch = 16;
  std::array<void*, batch> samples{};
  std::array<dds_sample_info_t, batch> infos{};
  for (;;) {
    const dds_return_t n = dds_take(reader, samples.data(), infos.data(), batch, batch);
    if (n <= 0) return;
    for (std::size_t i = 0; i < static_cast<std::size_t>(n); ++i) {
      use(*static_cast<const Sample*>(samples[i]), infos[i]);
    }
    dds_return_loan(reader, samples.data(), n);
    samples[0] = nullptr;
  }
}

struct MatchedEndpointDeleter {
  void operator()(dds_builtintopic_endpoint_t* info) const { dds_builtintopic_free_endpoint(info); }
};
using MatchedEndpoint = std::unique_ptr<dds_builtintopic_endpoint_t, MatchedEndpointDeleter>;

Participants::Guid to_guid(const dds_guid_t& guid) {
  Participants::Guid bytes{};
  std::ranges::copy(guid.v, bytes.begin());
  return bytes;
}

/// Each role has its topic: who listens to one of them only would miss something else.
tl::unexpected<Error> on_wrong_topic() {
  return fail(Errc::malformed, "an endpoint on the topic of the other role");
}

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
    const CycloneMessages messages;
    participant_ = dds_create_participant(domain(), participant_qos(mark_).get(), nullptr);
    dds_guid_t guid{};
    if (participant_ < 0 || dds_get_guid(participant_, &guid) != DDS_RETCODE_OK) {
      return fail(Errc::unavailable, "the DDS domain cannot be joined: " + messages.text() +
                                         "; check the network interfaces and CYCLONEDDS_URI");
    }
    guid_ = to_guid(guid);
    participants_.add_own(guid_);
    const ControlTopic::Matches matches{this, &on_subscription_matched, &on_publication_matched};
    const auto topic = [&](std::optional<ControlTopic>& made, const ControlTopic::Kind& kind, DdsQos qos) {
      made.emplace(participant_, kind, matches, std::move(qos));
    };
    topic(writers_, {&sft_control_Endpoint_desc, "sft_writer", &on_writers}, control_qos());
    topic(readers_, {&sft_control_ReaderWord_desc, "sft_reader", &on_readers}, control_qos());
    topic(lives_, {&sft_control_Assertion_desc, "sft_liveliness", &on_assertions}, assertion_qos(signs));
    Result<void> opened = lives_->hear();
    if (opened) opened = lives_->writer().map([](dds_entity_t) {});
    if (opened) opened = watch_participants();
    return opened;
  }

  Result<void> hear(Role role) override { return topic_of(role).hear(); }
  Result<void> write(const Endpoint& endpoint) override {
    ControlStorage storage;
    sft_control_Endpoint sample = to_dds(endpoint, storage);
    if (endpoint.role == Role::writer) return write_to(*writers_, &sample);
    const sft_control_ReaderWord word = in_word(sample);
    return write_to(*readers_, &word);
  }
  Result<void> write(const Request& request) override {
    sft_control_Request sample = to_dds(request);
    const sft_control_ReaderWord word = in_word(sample);
    return write_to(*readers_, &word);
  }
  void write(const Assertion& assertion) override {
    ControlStorage storage;
    const sft_control_Assertion sample = to_dds(assertion, storage);
    dds_write(lives_->known_writer(), &sample);
  }
  void dispose(EndpointId id, Role role) override {
    const dds_entity_t writer = topic_of(role).known_writer();
    if (writer == 0) return;
    if (role == Role::writer) {
      sft_control_Endpoint key{};
      key.id = id;
      dds_dispose(writer, &key);
      dds_unregister_instance(writer, &key);
      return;
    }
    sft_control_ReaderWord key{};
    key.reader = id;
    key.part = static_cast<std::uint8_t>(ReaderPart::announcement);
    dds_dispose(writer, &key);
    dds_unregister_instance(writer, &key);
    key.part = static_cast<std::uint8_t>(ReaderPart::request);
    dds_unregister_instance(writer, &key);
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
  using Writer = RemoteEndpoints::Writer;

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

  /// Empty for samples of the node itself, on this link or another; and if the writer is gone already and was
  /// not heard before: then nobody stands behind the sample.
  std::optional<Speaker> speaker_of(dds_entity_t reader, const dds_sample_info_t& info) {
    const std::optional<Writer> writer = writer_of(reader, info);
    if (!writer || writer->participant == 0) return std::nullopt;
    return Speaker{place_.link, writer->participant};
  }

  std::optional<Writer> writer_of(dds_entity_t reader, const dds_sample_info_t& info) {
    if (const auto known = remotes_.writer(info.publication_handle)) return known;
    const MatchedEndpoint matched(dds_get_matched_publication_data(reader, info.publication_handle));
    if (matched == nullptr) return std::nullopt;
    const Participants::Guid guid = to_guid(matched->participant_key);
    const Writer writer{participants_.is_own(guid) ? 0 : participants_.number_of(guid),
                        liveliness_lease(matched->qos)};
    remotes_.enter(info.publication_handle, writer);
    return writer;
  }

  /// The state of an instance may have changed since the sample came.
  static void on_writers(dds_entity_t reader, void* self) {
    CycloneLink& link = *static_cast<CycloneLink*>(self);
    take_all<sft_control_Endpoint>(reader,
                                   [&](const sft_control_Endpoint& sample, const dds_sample_info_t& info) {
                                     const std::optional<Speaker> speaker = link.speaker_of(reader, info);
                                     if (speaker && info.valid_data)
                                       link.writer_came(*speaker, from_dds(sample));
                                     link.told_of_end(speaker, sample.id, info);
                                   });
  }

  static void on_readers(dds_entity_t reader, void* self) {
    CycloneLink& link = *static_cast<CycloneLink*>(self);
    take_all<sft_control_ReaderWord>(reader,
                                     [&](const sft_control_ReaderWord& word, const dds_sample_info_t& info) {
                                       const std::optional<Speaker> speaker = link.speaker_of(reader, info);
                                       if (speaker && info.valid_data)
                                         link.reader_said(*speaker, from_dds(word));
                                       if (word.part == static_cast<std::uint8_t>(ReaderPart::announcement))
                                         link.told_of_end(speaker, word.reader, info);
                                     });
  }

  void told_of_end(const std::optional<Speaker>& speaker, EndpointId id, const dds_sample_info_t& info) {
    if (speaker && info.instance_state == DDS_IST_NOT_ALIVE_DISPOSED)
      listener_.endpoint_withdrawn(*speaker, id);
    if (info.instance_state == DDS_IST_NOT_ALIVE_NO_WRITERS) listener_.endpoint_unheard(place_.link, id);
  }

  void writer_came(const Speaker& speaker, Result<Endpoint> writer) {
    if (writer && writer->role != Role::writer) writer = on_wrong_topic();
    writer ? listener_.endpoint_came(speaker, std::move(*writer))
           : listener_.sample_malformed(writer.error().message);
  }

  void reader_said(const Speaker& speaker, Result<std::variant<Endpoint, Request>> said) {
    Endpoint* const reader = said ? std::get_if<Endpoint>(&*said) : nullptr;
    if (reader != nullptr && reader->role != Role::reader) said = on_wrong_topic();
    if (!said) return listener_.sample_malformed(said.error().message);
    if (auto* const request = std::get_if<Request>(&*said)) {
      listener_.request_came(speaker, std::move(*request));
    } else {
      listener_.endpoint_came(speaker, std::move(std::get<Endpoint>(*said)));
    }
  }

  /// Nodes unregister their signs of life, if they can. Somebody who disposes of them is not the node.
  static void on_assertions(dds_entity_t reader, void* self) {
    CycloneLink& link = *static_cast<CycloneLink*>(self);
    take_all<sft_control_Assertion>(
        reader, [&](const sft_control_Assertion& sample, const dds_sample_info_t& info) {
          const std::optional<Speaker> speaker = link.speaker_of(reader, info);
          if (info.valid_data && speaker)
            link.assertion_came(*speaker, from_dds(sample), link.lease_of(info.publication_handle));
          if (info.instance_state == DDS_IST_NOT_ALIVE_NO_WRITERS)
            link.listener_.node_unheard(link.place_.link, sample.node);
        });
  }

  void assertion_came(const Speaker& speaker, Result<Assertion> assertion, std::chrono::milliseconds lease) {
    assertion ? listener_.assertion_came(speaker, std::move(*assertion), lease)
              : listener_.sample_malformed(assertion.error().message);
  }
  std::chrono::milliseconds lease_of(dds_instance_handle_t handle) {
    const std::optional<Writer> writer = remotes_.writer(handle);
    return writer ? writer->lease : longest_lease;
  }

  static void on_subscription_matched(dds_entity_t reader, const dds_subscription_matched_status_t status,
                                      void* self) {
    const MatchedEndpoint there(status.current_count_change > 0
                                    ? dds_get_matched_publication_data(reader, status.last_publication_handle)
                                    : nullptr);
    static_cast<CycloneLink*>(self)->matched(status.last_publication_handle, there.get(),
                                             status.current_count_change);
  }
  static void on_publication_matched(dds_entity_t writer, const dds_publication_matched_status_t status,
                                     void* self) {
    const MatchedEndpoint there(status.current_count_change > 0 ? dds_get_matched_subscription_data(
                                                                      writer, status.last_subscription_handle)
                                                                : nullptr);
    static_cast<CycloneLink*>(self)->matched(status.last_subscription_handle, there.get(),
                                             status.current_count_change);
  }

  /// `there`: null if the reader or writer has departed.
  void matched(dds_instance_handle_t handle, const dds_builtintopic_endpoint_t* there, int change) {
    AnnouncerId participant = 0;
    if (there != nullptr) {
      const Participants::Guid guid = to_guid(there->participant_key);
      if (participants_.is_own(guid)) return;
      participant = participants_.number_of(guid);
      remotes_.matched(handle, participant);
    } else if (change < 0) {
      participant = remotes_.unmatched(handle);
    }
    if (participant == 0) return;
    const Speaker speaker{place_.link, participant};
    change > 0 ? listener_.endpoint_matched(speaker) : listener_.endpoint_unmatched(speaker);
  }

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
      remotes_.forget_writers_of(speaker.participant);
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
  Participants::Guid guid_{};  ///< of the participant
  dds_entity_t participant_ = 0;
  /// All of them are there once the link is open.
  std::optional<ControlTopic> writers_, readers_, lives_;
  RemoteEndpoints remotes_;
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
