#include "core/names/qos.h"

#include <cmath>

#include "core/platform/in_digits.h"

namespace sft::core {

namespace {

using std::chrono::nanoseconds;

constexpr std::uint32_t history_depth_max = 128;  // less than the number of chunks that a writer can hold at
                                                  // a time, which is 256
constexpr std::uint32_t depth_max = 1'000'000;    // more is surely a mistake

constexpr std::chrono::milliseconds shortest_watched{1};  // the shortest period that the agent can watch

Result<void> check_duration(const char* name, nanoseconds duration) {
  if (duration.count() >= 0) return {};
  return fail(Errc::invalid_argument, std::string(name) + " is negative; 0 is none");
}

/// Checks a deadline or lease. The agent must be able to watch the period.
Result<void> check_period(const char* name, nanoseconds period) {
  if (auto ok = check_duration(name, period); !ok) return ok;
  if (period.count() == 0 || period >= shortest_watched) return {};
  return fail(Errc::invalid_argument, std::string(name) + " " + text_of(period) + ": it is at least " +
                                          text_of(shortest_watched) + ", or 0 for none");
}

/// Checks max_blocking. It is limited because the agent may have to wait for a publish() that is running.
Result<void> check_max_blocking(nanoseconds longest) {
  if (auto ok = check_duration("max_blocking", longest); !ok) return ok;
  if (longest <= std::chrono::seconds(1)) return {};
  return fail(Errc::invalid_argument, "max_blocking " + text_of(longest) + ": it is at most 1 s");
}

Result<void> check_liveliness(Liveliness kind, nanoseconds lease) {
  if (auto ok = check_period("liveliness_lease", lease); !ok) return ok;
  if (kind == Liveliness::automatic || lease.count() != 0) return {};
  return fail(Errc::invalid_argument, "liveliness manual_by_topic needs a liveliness_lease");
}

/// Returns true if `offered` is at most `requested`. The value 0 means no limit, and so counts as longer
/// than any duration.
bool at_most(nanoseconds offered, nanoseconds requested) {
  if (requested.count() == 0) return true;
  return offered.count() != 0 && offered <= requested;
}

class Conflicts {
 public:
  void note(QosPolicy policy, const std::string& offered, const std::string& requested) {
    note(policy, to_string(policy), offered, requested);
  }
  void note(QosPolicy policy, const std::string& option, const std::string& offered,
            const std::string& requested) {
    if (conflict_.policy == QosPolicy::none) {
      conflict_ = {policy, "incompatible QoS: "};
    } else {
      conflict_.reason += "; ";
    }
    conflict_.reason += option + " " + offered + " is offered, " + requested + " is requested";
    of_publisher_ += " ." + option + " = " + requested;
    of_subscriber_ += " ." + option + " = " + offered;
  }
  QosConflict result() && {
    if (conflict_.policy != QosPolicy::none)
      conflict_.reason +=
          ": open the publisher with" + of_publisher_ + ", or the subscriber with" + of_subscriber_;
    return std::move(conflict_);
  }

 private:
  QosConflict conflict_;
  /// The options that each side has to set for the two sides to match.
  std::string of_publisher_, of_subscriber_;
};

std::string has_no_effect(const char* option, const std::string& why) {
  return std::string(option) + " has no effect: " + why;
}

}  // namespace

std::string text_of(nanoseconds duration) {
  const auto ns = duration.count();
  if (ns == 0) return "none";
  if (ns % 1'000'000 == 0) return std::to_string(ns / 1'000'000) + " ms";
  if (ns % 1'000 == 0) return std::to_string(ns / 1'000) + " us";
  return std::to_string(ns) + " ns";
}

Result<Qos> qos_of(const PublisherOptions& options) {
  const Qos qos{.reliability = options.reliability,
                .durability = options.durability,
                .deadline = options.deadline,
                .liveliness = options.liveliness,
                .liveliness_lease = options.liveliness_lease,
                .lifespan = options.lifespan,
                .history_depth = options.history_depth};
  if (qos.history_depth < 1 || qos.history_depth > history_depth_max) {
    return fail(Errc::invalid_argument, "history_depth is 1 to " + std::to_string(history_depth_max));
  }
  return check_period("deadline", qos.deadline)
      .and_then([&] { return check_duration("lifespan", qos.lifespan); })
      .and_then([&] { return check_max_blocking(options.max_blocking); })
      .and_then([&] { return check_liveliness(qos.liveliness, qos.liveliness_lease); })
      .map([&] { return qos; });
}

Result<Qos> qos_of(const SubscriberOptions& options) {
  const Qos qos{.reliability = options.reliability,
                .durability = options.durability,
                .deadline = options.deadline,
                .liveliness = options.liveliness,
                .liveliness_lease = options.liveliness_lease,
                .history_depth = options.depth};
  if (options.depth < 1 || options.depth > depth_max) {
    return fail(Errc::invalid_argument, "SubscriberOptions::depth is 1 to " + std::to_string(depth_max) +
                                            ", not " + std::to_string(options.depth));
  }
  const Result<std::uint32_t> period = min_period_us_of(options.max_rate_hz);
  if (!period) return tl::unexpected(period.error());
  if (options.deadline.count() != 0 && options.deadline < std::chrono::microseconds(*period)) {
    return fail(Errc::invalid_argument, "a deadline shorter than the period of max_rate_hz is always missed");
  }
  return check_period("deadline", qos.deadline)
      .and_then([&] { return check_period("liveliness_lease", qos.liveliness_lease); })
      .map([&] { return qos; });
}

std::vector<std::string> options_without_effect(const NodeOptions& options) {
  std::vector<std::string> sentences;
  const bool limits_udp = options.udp.port != 0 || options.udp.max_bytes_per_s != 0;
  if (limits_udp && options.transport == TransportChoice::shm)
    sentences.push_back(has_no_effect("NodeOptions::udp", "the node does not use UDP"));
  if (!options.shm.daemon_users.empty() && options.transport == TransportChoice::udp)
    sentences.push_back(has_no_effect("ShmSettings::daemon_users", "the node does not use shared memory"));
  if (!options.shm.daemon_path.empty() && !options.shm.start_daemon)
    sentences.push_back(has_no_effect("ShmSettings::daemon_path", "start_daemon is false"));
  return sentences;
}

std::vector<std::string> options_without_effect(const PublisherOptions& options, bool udp) {
  std::vector<std::string> sentences;
  if (options.max_blocking.count() != 0 && options.reliability == Reliability::best_effort) {
    sentences.push_back(
        has_no_effect("PublisherOptions::max_blocking",
                      "publish() waits for reliable subscribers only; set .reliability = reliable"));
  }
  if (options.history_depth != PublisherOptions{}.history_depth &&
      options.durability == Durability::volatile_) {
    sentences.push_back(has_no_effect(
        "PublisherOptions::history_depth",
        "only a publisher with .durability = transient_local keeps samples for late subscribers; "
        "SubscriberOptions::depth is the queue of a subscriber"));
  }
  if (options.asynchronous && options.max_blocking.count() != 0)
    sentences.push_back(has_no_effect("PublisherOptions::asynchronous", "max_blocking is not 0"));
  if (options.asynchronous && !udp)
    sentences.push_back(has_no_effect("PublisherOptions::asynchronous", "the publisher does not use UDP"));
  if (options.max_bytes_per_s != 0 && !udp)
    sentences.push_back(has_no_effect("PublisherOptions::max_bytes_per_s", "the publisher does not use UDP"));
  if (options.resend_bytes != PublisherOptions{}.resend_bytes && !udp)
    sentences.push_back(has_no_effect("PublisherOptions::resend_bytes", "the publisher does not use UDP"));
  if (options.resend_bytes != PublisherOptions{}.resend_bytes &&
      options.reliability == Reliability::best_effort) {
    sentences.push_back(
        has_no_effect("PublisherOptions::resend_bytes",
                      "only a reliable publisher sends samples again; set .reliability = reliable"));
  }
  return sentences;
}

std::vector<std::string> options_without_effect(const SubscriberOptions& options, bool shm, bool recorded) {
  const SubscriberOptions usual;
  std::vector<std::string> sentences;
  if (options.max_held != usual.max_held && !shm)
    sentences.push_back(
        has_no_effect("SubscriberOptions::max_held", "the subscriber does not use shared memory"));
  if (options.spin != usual.spin && options.pollable)
    sentences.push_back(has_no_effect("SubscriberOptions::spin", "the subscriber is pollable"));
  const bool sets_recording = options.recording.learn_samples != usual.recording.learn_samples ||
                              options.recording.narrow_after_samples != usual.recording.narrow_after_samples;
  if (sets_recording && !recorded) {
    sentences.push_back(
        has_no_effect("SubscriberOptions::recording",
                      "the fields are declared; a subscriber with sft::recorded records them"));
  }
  return sentences;
}

Result<std::uint32_t> min_period_us_of(double max_rate_hz) {
  constexpr double slowest_rate_hz = SubscriberOptions::slowest_rate_hz;
  constexpr double fastest_rate_hz = SubscriberOptions::fastest_rate_hz;
  if (max_rate_hz == 0) return 0;
  if (max_rate_hz >= slowest_rate_hz && max_rate_hz <= fastest_rate_hz) {
    return static_cast<std::uint32_t>(std::lround(1e6 / max_rate_hz));
  }
  return fail(Errc::invalid_argument, "max_rate_hz " + in_digits(max_rate_hz) + ": rates are " +
                                          in_digits(slowest_rate_hz) + " to " + in_digits(fastest_rate_hz) +
                                          " Hz, or 0 for any");
}

QosConflict conflict_between(const Qos& offered, const Qos& requested) {
  Conflicts conflicts;
  if (offered.reliability < requested.reliability) {
    conflicts.note(QosPolicy::reliability, to_string(offered.reliability), to_string(requested.reliability));
  }
  if (offered.durability < requested.durability) {
    conflicts.note(QosPolicy::durability, to_string(offered.durability), to_string(requested.durability));
  }
  if (!at_most(offered.deadline, requested.deadline)) {
    conflicts.note(QosPolicy::deadline, text_of(offered.deadline), text_of(requested.deadline));
  }
  if (offered.liveliness < requested.liveliness) {
    conflicts.note(QosPolicy::liveliness, to_string(offered.liveliness), to_string(requested.liveliness));
  }
  if (!at_most(offered.liveliness_lease, requested.liveliness_lease)) {
    conflicts.note(QosPolicy::liveliness, "liveliness_lease", text_of(offered.liveliness_lease),
                   text_of(requested.liveliness_lease));
  }
  return std::move(conflicts).result();
}

}  // namespace sft::core
