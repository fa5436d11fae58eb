#include "core/discovery/control_words.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "core/control/control_codec.h"
#include "core/discovery/control_qos.h"
#include "core/discovery/take_all.h"

namespace sft::core {

namespace {

struct MatchedEndpointDeleter {
  void operator()(dds_builtintopic_endpoint_t* info) const { dds_builtintopic_free_endpoint(info); }
};
using MatchedEndpoint = std::unique_ptr<dds_builtintopic_endpoint_t, MatchedEndpointDeleter>;

std::optional<Participants::Guid> participant_of(const MatchedEndpoint& matched) {
  if (matched == nullptr) return std::nullopt;
  return to_guid(matched->participant_key);
}

/// Empty if the writer is gone already and was not heard before: then nobody stands behind the sample.
std::optional<RemoteWriters::Writer> writer_of(dds_entity_t reader, const dds_sample_info_t& info,
                                               RemoteWriters& writers) {
  if (const auto known = writers.writer(info.publication_handle)) return known;
  const MatchedEndpoint matched(dds_get_matched_publication_data(reader, info.publication_handle));
  const std::optional<Participants::Guid> participant = participant_of(matched);
  if (!participant) return std::nullopt;
  const RemoteWriters::Writer writer{*participant, liveliness_lease(matched->qos)};
  writers.enter(info.publication_handle, writer);
  return writer;
}

/// Each role has its topic: who listens to one of them only would miss something else.
ControlWord announcement(const Participants::Guid& speaker, Endpoint endpoint, Role role_of_topic) {
  if (endpoint.role != role_of_topic)
    return {speaker, SampleMalformed{"an endpoint on the topic of the other role"}};
  return {speaker, std::move(endpoint)};
}

ControlWord said(const RemoteWriters::Writer& by, const sft_control_Endpoint& sample) {
  Result<Endpoint> endpoint = from_dds(sample);
  if (!endpoint) return {by.participant, SampleMalformed{endpoint.error().message}};
  return announcement(by.participant, std::move(*endpoint), Role::writer);
}

ControlWord said(const RemoteWriters::Writer& by, const sft_control_ReaderWord& sample) {
  Result<std::variant<Endpoint, Request>> word = from_dds(sample);
  if (!word) return {by.participant, SampleMalformed{word.error().message}};
  if (auto* const request = std::get_if<Request>(&*word)) return {by.participant, std::move(*request)};
  return announcement(by.participant, std::move(std::get<Endpoint>(*word)), Role::reader);
}

ControlWord said(const RemoteWriters::Writer& by, const sft_control_Assertion& sample) {
  Result<Assertion> assertion = from_dds(sample);
  if (!assertion) return {by.participant, SampleMalformed{assertion.error().message}};
  return {by.participant, SignOfLife{std::move(*assertion), by.lease}};
}

/// True if an endpoint ends with the instance of that sample.
bool is_announcement(const sft_control_Endpoint&) { return true; }
bool is_announcement(const sft_control_ReaderWord& sample) {
  return sample.part == static_cast<std::uint8_t>(ReaderPart::announcement);
}

template <class Sample>
ControlWords take_endpoints(dds_entity_t reader, Heard& heard) {
  ControlWords words;
  take_all<Sample>(reader, [&](const Sample& sample, const dds_sample_info_t& info) {
    const std::optional<RemoteWriters::Writer> writer = writer_of(reader, info, heard.writers);
    const auto speaker = writer ? std::optional(writer->participant) : std::nullopt;
    if (writer && info.valid_data) {
      ControlWord word = said(*writer, sample);
      if (const auto* const endpoint = std::get_if<Endpoint>(&word.what)) {
        if (const auto ended = heard.keys.announced(*speaker, sample.instance, endpoint->id))
          words.push_back({speaker, EndpointWithdrawn{*ended}});
      }
      words.push_back(std::move(word));
    }
    if (!is_announcement(sample)) return;
    // The state of the instance may have changed since the sample came.
    if (speaker && info.instance_state == DDS_IST_NOT_ALIVE_DISPOSED) {
      if (const auto ended = heard.keys.withdrawn(*speaker, sample.instance))
        words.push_back({speaker, EndpointWithdrawn{*ended}});
    }
    if (info.instance_state == DDS_IST_NOT_ALIVE_NO_WRITERS) {
      for (const EndpointId ended : heard.keys.unheard(sample.instance))
        words.push_back({speaker, EndpointUnheard{ended}});
    }
  });
  return words;
}

}  // namespace

ControlWords take_writers(dds_entity_t reader, Heard& heard) {
  return take_endpoints<sft_control_Endpoint>(reader, heard);
}

ControlWords take_readers(dds_entity_t reader, Heard& heard) {
  return take_endpoints<sft_control_ReaderWord>(reader, heard);
}

/// Nodes unregister their signs of life, if they can. Somebody who disposes of them is not the node.
ControlWords take_assertions(dds_entity_t reader, Heard& heard) {
  ControlWords words;
  take_all<sft_control_Assertion>(
      reader, [&](const sft_control_Assertion& sample, const dds_sample_info_t& info) {
        const std::optional<RemoteWriters::Writer> writer = writer_of(reader, info, heard.writers);
        if (writer && info.valid_data) words.push_back(said(*writer, sample));
        if (info.instance_state == DDS_IST_NOT_ALIVE_NO_WRITERS)
          words.push_back({std::nullopt, NodeUnheard{sample.node}});
      });
  return words;
}

std::optional<Participants::Guid> publishing_participant(dds_entity_t reader, dds_instance_handle_t writer) {
  return participant_of(MatchedEndpoint(dds_get_matched_publication_data(reader, writer)));
}

std::optional<Participants::Guid> subscribing_participant(dds_entity_t writer, dds_instance_handle_t reader) {
  return participant_of(MatchedEndpoint(dds_get_matched_subscription_data(writer, reader)));
}

Participants::Guid to_guid(const dds_guid_t& guid) {
  Participants::Guid bytes{};
  std::ranges::copy(guid.v, bytes.begin());
  return bytes;
}

}  // namespace sft::core
