#include "tools/perf/protocol.h"

#include <nlohmann/json.hpp>
#include <random>

namespace sft::perf {

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Part, answer, sample)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Usage, cpu_s, switches, bytes_in, bytes_out, memory_bytes)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(HostClock, boot, is_kept, error_s)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Report::Stream, publisher, received, lost, parts)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Offer, version, session, mark, ends, type, definition, fields, transport,
                                   reliable, answers, loans, udp, tcp)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Report, version, session, side, mark, error, clock, usage, streams,
                                   udp_port, tcp_port, udp_received, tcp_received)

namespace {

using Text = nlohmann::json;

/// Returns the message that `text` contains; nothing if a member is missing or has another type. In these
/// cases the JSON library throws.
template <class T>
std::optional<T> parsed(std::string_view text) {
  try {
    T result = Text::parse(text).get<T>();
    if (result.version == T{}.version) return result;
  } catch (const Text::exception&) {
  }
  return std::nullopt;
}

template <class T>
std::string written(const T& object) {
  return Text(object).dump(-1, ' ', false, Text::error_handler_t::replace);
}

}  // namespace

std::string text_of(const Offer& offer) { return written(offer); }
std::string text_of(const Report& report) { return written(report); }

std::optional<Offer> offer_of(std::string_view text) {
  std::optional<Offer> offer = parsed<Offer>(text);
  if (offer && offer->transport > TransportChoice::udp) offer.reset();
  return offer;
}

std::optional<Report> report_of(std::string_view text) { return parsed<Report>(text); }

std::string topic_of(std::uint64_t session, std::string_view part) {
  return "sft_perf/s" + std::to_string(session) + "/" + std::string(part);
}

DynamicType text_type() { return from_msg("std_msgs/String", "string data\n").value(); }

Result<void> publish_text(DynamicPublisher& publisher, const std::string& text) {
  return publisher.publish_json(Text{{"data", text}}.dump()).map([](PublishStatus) {});
}

std::optional<std::string> take_text(DynamicSubscriber& subscriber) {
  const DynamicSample sample = subscriber.take();
  if (!sample) return std::nullopt;
  return sample.view()["data"].as<std::string>().value_or("");
}

PublisherOptions retained() { return {.reliability = reliable, .durability = transient_local}; }

std::uint64_t random_number() {
  std::random_device device;
  return (std::uint64_t{device()} << 32 | device()) | 1;
}

}  // namespace sft::perf
