// Stamps and durations of messages as std::chrono has them. For builtin_interfaces/Time and Duration and what
// looks like them: `sec` and `nanosec`, of owned messages or of samples that are read in place.
//
//   const auto age = std::chrono::system_clock::now() - sft::to_time(sample->header().stamp());
//   message.header.stamp =
//   sft::time_message<builtin_interfaces::msg::Time>(std::chrono::system_clock::now()); message.lifetime =
//   sft::duration_message<builtin_interfaces::msg::Duration>(100ms);
//
// All of it is pure, and costs a multiplication or a division.
#pragma once

#include <algorithm>
#include <chrono>
#include <concepts>
#include <cstdint>
#include <limits>
#include <optional>
#include <type_traits>

namespace sft {

namespace detail {

template <class S>
concept OwnedSeconds = requires(const S& s) {
  { s.sec } -> std::convertible_to<std::int64_t>;
  { s.nanosec } -> std::convertible_to<std::int64_t>;
};
/// A view, whose getters return optionals where fields are recorded.
template <class S>
concept ReadSeconds = requires(const S& s) {
  s.sec();
  s.nanosec();
};

template <class V>
inline constexpr bool is_optional = requires(const V& v) {
  v.has_value();
};

constexpr std::chrono::nanoseconds together(std::int64_t sec, std::int64_t nanosec) {
  return std::chrono::seconds(sec) + std::chrono::nanoseconds(nanosec);
}

/// Whole seconds, rounded down, and the rest from 0 to 999,999,999: what does not fit is the nearest that
/// does.
template <class Message>
constexpr Message seconds_message(std::chrono::nanoseconds time) {
  using Sec = std::remove_cvref_t<decltype(Message{}.sec)>;
  using Nanosec = std::remove_cvref_t<decltype(Message{}.nanosec)>;
  constexpr std::int64_t per_second = 1'000'000'000;
  const std::int64_t rest = (time.count() % per_second + per_second) % per_second;
  const std::int64_t whole = time.count() / per_second - (time.count() % per_second < 0 ? 1 : 0);
  constexpr auto least = static_cast<std::int64_t>(std::numeric_limits<Sec>::min());
  constexpr auto most = static_cast<std::int64_t>(std::numeric_limits<Sec>::max());
  Message message{};
  message.sec = static_cast<Sec>(std::clamp(whole, least, most));
  message.nanosec = static_cast<Nanosec>(rest);
  if (whole < least) message.nanosec = 0;
  if (whole > most) message.nanosec = 999'999'999;
  return message;
}

template <class S>
concept SecondsMessage = OwnedSeconds<S> || ReadSeconds<S>;

}  // namespace detail

/// builtin_interfaces/Duration in ns. Of a sample whose fields are recorded a std::optional: empty if it does
/// not have both fields. No value of a message is out of range.
template <detail::SecondsMessage S>
constexpr auto to_duration(const S& duration) {
  if constexpr (detail::OwnedSeconds<S>) {
    return detail::together(duration.sec, duration.nanosec);
  } else if constexpr (detail::is_optional<decltype(duration.sec())>) {
    const auto sec = duration.sec();
    const auto nanosec = duration.nanosec();
    std::optional<std::chrono::nanoseconds> both;
    if (sec && nanosec) both = detail::together(*sec, *nanosec);
    return both;
  } else {
    return detail::together(duration.sec(), duration.nanosec());
  }
}

/// builtin_interfaces/Time as a point in time since 1970-01-01 in UTC, as std::chrono::system_clock counts,
/// and SampleInfo's stamps; of a stamp of simulated time, since that began. Optional as to_duration() is.
template <detail::SecondsMessage S>
constexpr auto to_time(const S& stamp) {
  using Time = std::chrono::sys_time<std::chrono::nanoseconds>;
  const auto since_epoch = to_duration(stamp);
  if constexpr (detail::is_optional<decltype(since_epoch)>) {
    return since_epoch ? std::optional(Time(*since_epoch)) : std::nullopt;
  } else {
    return Time(since_epoch);
  }
}

/// The message of a duration: seconds rounded down, so that the nanoseconds are never negative. Beyond what
/// `sec` can hold (32 bits) it is the nearest that it can.
template <detail::OwnedSeconds Message>
constexpr Message duration_message(std::chrono::nanoseconds duration) {
  return detail::seconds_message<Message>(duration);
}

/// The message of a point in time; likewise, so up to 2038-01-19.
template <detail::OwnedSeconds Message>
constexpr Message time_message(std::chrono::sys_time<std::chrono::nanoseconds> time) {
  return detail::seconds_message<Message>(time.time_since_epoch());
}

}  // namespace sft
