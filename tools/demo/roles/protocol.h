// What the demo and its roles say to each other: the demo asks, the role answers with a report.
#pragma once

#include <cstdint>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tools/demo/roles/channel.h"
#include "tools/demo/roles/traffic.h"

template <class T>
struct nlohmann::adl_serializer<std::optional<T>> {
  static void to_json(json& j, const std::optional<T>& value) { j = value ? json(*value) : json(nullptr); }
  static void from_json(const json& j, std::optional<T>& value) {
    value = j.is_null() ? std::nullopt : std::optional(j.get<T>());
  }
};

namespace sft::demo {

inline constexpr std::string_view topic = "points";

/// Asked of every role. A closed channel tells it to end.
struct Order {
  enum class Kind {
    report,
    publish,
    halt
  };  ///< the last two are for the publisher, and answered with a report as well
  Kind kind = Kind::report;
  double hz = 0;              ///< publish
  std::uint64_t samples = 0;  ///< publish
};

/// A reader as its publisher sees it.
struct ReaderReport {
  std::string node;
  bool served = false;
  std::string transport;
  std::string reason;
  std::uint64_t withheld = 0;  ///< not sent to it, since it asks for a lower rate
};

struct PublisherReport {
  std::uint64_t published = 0;
  std::uint64_t dropped = 0;     ///< not handed over to some reader, which counts it as lost
  std::uint64_t full_bytes = 0;  ///< of all that was published: encapsulation and body of the whole messages
  bool finished = false;         ///< all that was ordered is published
  std::vector<ReaderReport> readers;
  std::string udp;  ///< how UDP works on its host, as the library says it
  std::string shm;  ///< likewise
  bool shm_ready = false;
  std::string warning;  ///< the last one that the library gave
  Traffic traffic;
};

/// The state of a recorded subscriber when its mask had just narrowed for the first time.
struct LearningReport {
  std::uint64_t received = 0;
  std::uint64_t payload_bytes = 0;
  Traffic traffic;
};

struct SubscriberReport {
  bool matched = false;
  std::string transport;
  std::string reason;
  std::vector<std::string> fields;        ///< asked for at present
  std::vector<std::string> other_fields;  ///< the rest
  std::uint64_t received = 0;
  std::uint64_t lost = 0;
  std::uint64_t incomplete = 0;     ///< of the lost ones: some of it came
  std::uint64_t payload_bytes = 0;  ///< of all that was received
  std::optional<double> latency_p50_us;
  std::optional<double> latency_p99_us;
  std::optional<LearningReport> learning;
  std::string warning;
  Traffic traffic;
};

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Order, kind, hz, samples)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Traffic, at_ns, received, sent, control_received, control_sent)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(ReaderReport, node, served, transport, reason, withheld)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(PublisherReport, published, dropped, full_bytes, finished, readers, udp,
                                   shm, shm_ready, warning, traffic)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(LearningReport, received, payload_bytes, traffic)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(SubscriberReport, matched, transport, reason, fields, other_fields,
                                   received, lost, incomplete, payload_bytes, latency_p50_us, latency_p99_us,
                                   learning, warning, traffic)

/// The role's side where it cannot go on: answers the next order with the error.
void refuse(Channel& channel, const Error& error);

/// Called several times a second while an answer is waited for. An error ends the wait, and is what it
/// returns.
using WhileWaiting = std::function<Result<void>()>;

namespace detail {
Result<nlohmann::json> ask(Channel& channel, std::string_view role, const Order& order,
                           Clock::duration patience, const WhileWaiting& while_waiting);
}

/// Sends the order and waits for the answer. `role` names the other side in errors.
template <class Report>
Result<Report> ask(Channel& channel, std::string_view role, const Order& order, Clock::duration patience,
                   const WhileWaiting& while_waiting = {}) {
  return detail::ask(channel, role, order, patience, while_waiting).map([](const nlohmann::json& j) {
    return j.get<Report>();
  });
}

}  // namespace sft::demo
