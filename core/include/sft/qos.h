// Quality of service, with the names and rules of DDS, which ROS 2 uses, too. A publisher must offer at
// least what a subscriber requests. Otherwise the two never match, and both get an event that names the
// incompatible policy.
//
//   policy       matches if
//   reliability  offered >= requested, best_effort < reliable
//   durability   offered >= requested, volatile_ < transient_local
//   deadline     offered <= requested, none is the longest
//   liveliness   kind: offered >= requested, automatic < manual_by_topic; lease: offered <= requested
//
// History, lifespan and rate concern only one side, and do not take part in matching. All types of this
// header are plain values.
#pragma once

#include <chrono>
#include <cstdint>

namespace sft {

/// The treatment of samples that are lost on the way.
enum class Reliability : std::uint8_t {
  best_effort,  ///< a lost sample is only counted
  /// Samples arrive in order, and no sample is lost as long as the subscriber does not lag by more than its
  /// depth. Over UDP a lost sample is sent again as long as the publisher keeps it. The publisher keeps the
  /// last 64 MB (PublisherOptions::resend_bytes) or 4096 samples that were not acknowledged (ResendLimits),
  /// and fewer if many subscribers lag: for all of them together, the node uses at most half of its memory
  /// (UdpSettings::memory_limit_bytes). In shared memory only the samples within the depth are kept, at
  /// most 256. On either path the total size of these samples is also limited
  /// (SubscriberOptions::depth_bytes). If a publisher is faster than a subscriber, that subscriber loses
  /// the oldest of these samples, on either path. The publisher can wait instead
  /// (PublisherOptions::max_blocking); as long as it waits, nothing is lost. Samples that are lost
  /// nevertheless are counted, and logged as a warning.
  reliable,
};
/// Decides which samples a subscriber gets that were published before it joined.
enum class Durability : std::uint8_t {
  volatile_,  ///< none: the subscriber gets only samples that are published once it is served
  /// The last samples of each publisher, as many as both publisher and subscriber keep
  /// (PublisherOptions::history_depth, SubscriberOptions::depth). They are sent by UDP, even within a host,
  /// or in shared memory if the pair must not use UDP. A reliable subscriber gets all of them, whatever
  /// their size: they are sent at the pace at which it acknowledges them. Samples that are published
  /// meanwhile follow. The retained samples stay in memory until they have been sent, even if the publisher
  /// retains newer samples by then.
  transient_local,
};
/// The way in which a publisher shows that it is alive.
enum class Liveliness : std::uint8_t {
  /// A publisher is alive as long as its node is. If a subscriber requests a lease, the node sends three
  /// signs of life per lease, each for all its publishers together, in about 155 bytes.
  automatic,
  /// A publisher is alive as long as the program calls publish() or assert_liveliness() once in each lease.
  manual_by_topic,
};
using enum Reliability;
using enum Durability;
using Liveliness::manual_by_topic;

/// A policy that can be incompatible between an offer and a request, or none.
enum class QosPolicy : std::uint8_t { none, reliability, durability, deadline, liveliness };

/// The offer of a publisher or the request of a subscriber. A duration of 0 means none.
struct Qos {
  Reliability reliability = Reliability::best_effort;  ///< a reliable offer satisfies each request
  Durability durability = Durability::volatile_;       ///< a transient_local offer satisfies each request
  std::chrono::nanoseconds deadline{0};                ///< the maximum time between two samples
  Liveliness liveliness = Liveliness::automatic;       ///< a manual_by_topic offer satisfies each request
  /// The maximum time between two assertions that a publisher is alive.
  std::chrono::nanoseconds liveliness_lease{0};
  // The following members do not affect matching.
  std::chrono::nanoseconds lifespan{0};  ///< only for publishers: the age at which samples expire
  /// Publishers: the number of samples kept for late subscribers. Subscribers: the number of samples kept
  /// until they are taken.
  std::uint32_t history_depth = 1;
  friend bool operator==(const Qos&, const Qos&) = default;
};

constexpr const char* to_string(Reliability kind) {
  return kind == Reliability::reliable ? "reliable" : "best_effort";
}
constexpr const char* to_string(Durability kind) {
  return kind == Durability::transient_local ? "transient_local" : "volatile";
}
constexpr const char* to_string(Liveliness kind) {
  return kind == Liveliness::manual_by_topic ? "manual_by_topic" : "automatic";
}
constexpr const char* to_string(QosPolicy policy) {
  constexpr const char* names[] = {"none", "reliability", "durability", "deadline", "liveliness"};
  return names[static_cast<std::uint8_t>(policy)];
}

}  // namespace sft
