// Quality of service, with the names and rules of DDS (ROS 2 has the same): what a publisher offers must be
// at least what a subscriber requests, or the two never match, and both are told which policy is to blame.
//
//   policy       matches if
//   reliability  offered >= requested, best_effort < reliable
//   durability   offered >= requested, volatile_ < transient_local
//   deadline     offered <= requested, none is the longest
//   liveliness   kind: offered >= requested, automatic < manual_by_topic; lease: offered <= requested
//
// History, lifespan and rate are each side's own affair.
#pragma once

#include <chrono>
#include <cstdint>

namespace sft {

enum class Reliability : std::uint8_t {
  best_effort,
  /// Nothing is lost but beyond the subscriber's depth, and in order. Over UDP what was lost on the way is
  /// sent again, as long as the publisher keeps it: the last 64 MB or 4096 samples that were not
  /// acknowledged (ResendLimits); less where many subscribers lag, for all of which the node keeps at most
  /// half of its memory (UdpSettings::memory_limit_bytes). In shared memory the depth is all there is, up to
  /// 256 samples. A publisher that is faster than a subscriber loses it the oldest of these, or waits for it,
  /// on whichever path (PublisherOptions::max_blocking): then nothing is lost beyond the depth either, as
  /// long as it waits. What is lost nevertheless is counted, and logged as a warning.
  reliable,
};
enum class Durability : std::uint8_t {
  volatile_,  ///< a subscriber gets what is published from when it is served
  /// And before that the last samples of each publisher, as many as both sides keep
  /// (PublisherOptions::history_depth, SubscriberOptions::depth). They come by UDP, within a host too, or in
  /// shared memory where the pair rules UDP out. A reliable subscriber gets all of them, whatever their size:
  /// they leave as it acknowledges them, and what is published meanwhile follows. Until they have left they
  /// stay in memory, although the publisher may retain newer ones by then.
  transient_local,
};
enum class Liveliness : std::uint8_t {
  /// A publisher is alive as long as its node is. Where a subscriber asks for a lease, the node says so three
  /// times in each, for all its publishers at once, in some 155 bytes.
  automatic,
  manual_by_topic,  ///< as long as it publishes, or says so by assert_liveliness()
};
using enum Reliability;
using enum Durability;
using Liveliness::manual_by_topic;

enum class QosPolicy : std::uint8_t { none, reliability, durability, deadline, liveliness };

/// What a publisher offers or a subscriber requests. Durations of 0: none.
struct Qos {
  Reliability reliability = Reliability::best_effort;  ///< a reliable offer satisfies each request
  Durability durability = Durability::volatile_;       ///< a transient_local offer satisfies each request
  std::chrono::nanoseconds deadline{0};                ///< the longest time between two samples
  Liveliness liveliness = Liveliness::automatic;       ///< a manual_by_topic offer satisfies each request
  std::chrono::nanoseconds liveliness_lease{0};        ///< the longest time between two signs of life
  // These take no part in matching:
  std::chrono::nanoseconds lifespan{0};  ///< publishers
  std::uint32_t history_depth = 1;       ///< publishers: samples kept for late ones; subscribers: until taken
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
