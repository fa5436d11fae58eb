#include "core/discovery/discovery_link.h"

#include <dds/dds.h>

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <string_view>

#include "core/control/control_codec.h"
#include "core/discovery/control_qos.h"
#include "core/discovery/dds_domain.h"
#include "core/discovery/participant_mark.h"
#include "core/discovery/remote_endpoints.h"

namespace sft::core {

namespace {

struct ListenerDeleter {
  void operator()(dds_listener_t* listener) const { dds_delete_listener(listener); }
};
using Listener = std::unique_ptr<dds_listener_t, ListenerDeleter>;

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
    const DdsQos qos = control_qos();
    const DdsQos unreliable = assertion_qos(signs);
    auto endpoints = make_topic(&sft_control_Endpoint_desc, "sft_endpoint", qos.get(), &on_endpoints);
    if (!endpoints) return tl::unexpected(endpoints.error());
    auto requests = make_topic(&sft_control_Request_desc, "sft_request", qos.get(), &on_requests);
    if (!requests) return tl::unexpected(requests.error());
    auto assertions =
        make_topic(&sft_control_Assertion_desc, "sft_liveliness", unreliable.get(), &on_assertions);
    if (!assertions) return tl::unexpected(assertions.error());
    endpoint_writer_ = *endpoints;
    request_writer_ = *requests;
    assertion_writer_ = *assertions;
    return watch_participants();
  }

  Result<void> write(const Endpoint& endpoint) override {
    ControlStorage storage;
    const sft_control_Endpoint sample = to_dds(endpoint, storage);
    return written(dds_write(endpoint_writer_, &sample));
  }
  Result<void> write(const Request& request) override {
    const sft_control_Request sample = to_dds(request);
    return written(dds_write(request_writer_, &sample));
  }
  void write(const Assertion& assertion) override {
    ControlStorage storage;
    const sft_control_Assertion sample = to_dds(assertion, storage);
    dds_write(assertion_writer_, &sample);
  }
  void dispose(EndpointId id) override {
    sft_control_Endpoint key{};
    key.id = id;
    dds_dispose(endpoint_writer_, &key);
    dds_unregister_instance(endpoint_writer_, &key);
    sft_control_Request request_key{};
    request_key.reader = id;
    dds_unregister_instance(request_writer_, &request_key);
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
    dds_wait_for_acks(endpoint_writer_, DDS_MSECS(patience.count()));
  }

 private:
  using Writer = RemoteEndpoints::Writer;

  dds_domainid_t domain() const { return place_.domain == nullptr ? place_.number : place_.domain->id(); }

  Result<dds_entity_t> make_topic(const dds_topic_descriptor_t* type, const char* name, const dds_qos_t* qos,
                                  dds_on_data_available_fn on_data) {
    const dds_entity_t topic = dds_create_topic(participant_, type, name, qos, nullptr);
    const Listener of_reader = listener_with(on_data);
    dds_lset_subscription_matched(of_reader.get(), &on_subscription_matched);
    const dds_entity_t reader =
        topic < 0 ? topic : dds_create_reader(participant_, topic, hearing_qos(qos).get(), of_reader.get());
    const Listener of_writer(dds_create_listener(this));
    dds_lset_publication_matched(of_writer.get(), &on_publication_matched);
    const dds_entity_t writer =
        reader < 0 ? reader : dds_create_writer(participant_, topic, qos, of_writer.get());
    if (writer < 0) {
      return fail(Errc::system, std::string("control topic ") + name + ": " + dds_strretcode(writer));
    }
    return writer;
  }

  Result<void> watch_participants() {
    const Listener listener = listener_with(&on_participants);
    const dds_entity_t reader =
        dds_create_reader(participant_, DDS_BUILTIN_TOPIC_DCPSPARTICIPANT, nullptr, listener.get());
    if (reader >= 0) return {};
    return fail(Errc::system, std::string("the participants cannot be watched: ") + dds_strretcode(reader));
  }

  Listener listener_with(dds_on_data_available_fn on_data) {
    Listener listener(dds_create_listener(this));
    dds_lset_data_available(listener.get(), on_data);
    return listener;
  }

  static Result<void> written(dds_return_t status) {
    if (status == DDS_RETCODE_OK) return {};
    return fail(Errc::system, std::string("a control sample was not written: ") + dds_strretcode(status));
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
  static void on_endpoints(dds_entity_t reader, void* self) {
    CycloneLink& link = *static_cast<CycloneLink*>(self);
    take_all<sft_control_Endpoint>(
        reader, [&](const sft_control_Endpoint& sample, const dds_sample_info_t& info) {
          if (const std::optional<Speaker> speaker = link.speaker_of(reader, info)) {
            if (info.valid_data) link.endpoint_came(*speaker, from_dds(sample));
            if (info.instance_state == DDS_IST_NOT_ALIVE_DISPOSED)
              link.listener_.endpoint_withdrawn(*speaker, sample.id);
          }
          if (info.instance_state == DDS_IST_NOT_ALIVE_NO_WRITERS)
            link.listener_.endpoint_unheard(link.place_.link, sample.id);
        });
  }

  void endpoint_came(const Speaker& speaker, Result<Endpoint> endpoint) {
    endpoint ? listener_.endpoint_came(speaker, std::move(*endpoint))
             : listener_.sample_malformed(endpoint.error().message);
  }

  static void on_requests(dds_entity_t reader, void* self) {
    CycloneLink& link = *static_cast<CycloneLink*>(self);
    take_all<sft_control_Request>(reader,
                                  [&](const sft_control_Request& sample, const dds_sample_info_t& info) {
                                    if (!info.valid_data) return;  // the reader's endpoint tells of its end
                                    const std::optional<Speaker> speaker = link.speaker_of(reader, info);
                                    if (!speaker) return;
                                    Result<Request> request = from_dds(sample);
                                    request ? link.listener_.request_came(*speaker, std::move(*request))
                                            : link.listener_.sample_malformed(request.error().message);
                                  });
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
  dds_entity_t endpoint_writer_ = 0;
  dds_entity_t request_writer_ = 0;
  dds_entity_t assertion_writer_ = 0;
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
