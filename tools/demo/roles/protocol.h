// The messages between the demo and its roles: the demo asks, and the role answers with a report.
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

/// The demo sends orders to every role. A closed channel tells the role to end.
struct Order {
  /// Each order is answered with a report. Only the publisher gets orders to publish or halt.
  enum class Kind { report, publish, halt };
  Kind kind = Kind::report;
  double hz = 0;              ///< the rate of publishing, for Kind::publish
  std::uint64_t samples = 0;  ///< the number of samples for Kind::publish
};

/// A reader as its publisher sees it.
struct ReaderReport {
  std::string node;
  bool served = false;
  std::string transport;
  std::string reason;
  std::uint64_t withheld = 0;  ///< samples that were not sent, since the reader asks for a lower rate
};

struct PublisherReport {
  std::uint64_t published = 0;
  std::uint64_t dropped = 0;     ///< samples that were not sent to some reader, which counts them as lost
  std::uint64_t full_bytes = 0;  ///< encapsulation and body of a whole message
  bool finished = false;         ///< nothing remains to be published
  std::vector<ReaderReport> readers;
  std::string udp;  ///< NodeStatus::udp
  std::string shm;  ///< NodeStatus::shm
  bool shm_ready = false;
  std::string warning;  ///< the last warning of the library
  Traffic traffic;
};

/// The state of a recorded subscriber at the moment when its mask narrowed for the first time.
struct LearningReport {
  std::uint64_t received = 0;
  std::uint64_t payload_bytes = 0;
  Traffic traffic;
};

/// The state of a subscription.
struct Reception {
  std::string transport;                  ///< "shm" or "udp"
  std::string reason;                     ///< why this transport is used
  std::vector<std::string> fields;        ///< the fields that the subscriber asks for at present
  std::vector<std::string> other_fields;  ///< all fields that are not in `fields`
  std::uint64_t received = 0;
  std::uint64_t lost = 0;
  std::uint64_t incomplete = 0;  ///< lost samples of which a part came
  std::optional<double> latency_p50_us;
  std::optional<double> latency_p99_us;
};

struct SubscriberReport : Reception {
  bool matched = false;
  std::uint64_t payload_bytes = 0;  ///< sum over all received samples
  std::optional<LearningReport> learning;
  std::string warning;
  Traffic traffic;
};

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Order, kind, hz, samples)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Traffic, received, control_received)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(ReaderReport, node, served, transport, reason, withheld)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(PublisherReport, published, dropped, full_bytes, finished, readers, udp,
                                   shm, shm_ready, warning, traffic)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(LearningReport, received, payload_bytes, traffic)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(SubscriberReport, matched, transport, reason, fields, other_fields,
                                   received, lost, incomplete, payload_bytes, latency_p50_us, latency_p99_us,
                                   learning, warning, traffic)

/// Answers the next order with the error. A role that cannot go on calls this.
void refuse(Channel& channel, const Error& error);

/// Called several times in a second by a function that waits for an answer. If it returns an error, the wait
/// ends with that error.
using WhileWaiting = std::function<Result<void>()>;

namespace detail {
Result<nlohmann::json> ask(Channel& channel, std::string_view role, const Order& order,
                           Clock::duration timeout, const WhileWaiting& while_waiting);
}

/// Sends the order and waits for the answer. `role` names the other side in errors.
template <class Report>
Result<Report> ask(Channel& channel, std::string_view role, const Order& order, Clock::duration timeout,
                   const WhileWaiting& while_waiting = {}) {
  return detail::ask(channel, role, order, timeout, while_waiting).map([](const nlohmann::json& j) {
    return j.get<Report>();
  });
}

}  // namespace sft::demo
