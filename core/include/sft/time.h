// Stamps and durations of messages as std::chrono types. They work with builtin_interfaces/Time and Duration,
// and with other messages that have `sec` and `nanosec`, both in messages of the program's own and in samples
// that are read in place.
//
//   const auto age = std::chrono::system_clock::now() - sft::to_time(sample->header().stamp());
//   message.header.stamp = sft::time_message<Time>(std::chrono::system_clock::now());
//   message.lifetime = sft::duration_message<Duration>(100ms);
//
// All functions are pure. Any thread may call them, none of them fails, and each costs one multiplication or
// division.
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
/// A view of a message with the getters `sec` and `nanosec`, which return optionals if fields are recorded
/// or selected.
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

/// Returns whole seconds, rounded down, and the remaining nanoseconds, from 0 to 999,999,999. If the time
/// does not fit into `sec`, the result is the nearest time that does.
template <class Message>
constexpr Message seconds_message(std::chrono::nanoseconds time) {
  using Sec = std::remove_cvref_t<decltype(Message{}.sec)>;
  using Nanosec = std::remove_cvref_t<decltype(Message{}.nanosec)>;
  constexpr std::int64_t per_second = 1'000'000'000;
  const std::int64_t rest = (time.count() % per_second + per_second) % per_second;
  const std::int64_t whole = time.count() / per_second - (time.count() % per_second < 0 ? 1 : 0);
  constexpr auto least = static_cast<std::int64_t>((std::numeric_limits<Sec>::min)());
  constexpr auto most = static_cast<std::int64_t>((std::numeric_limits<Sec>::max)());
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

/// Returns the value of a builtin_interfaces/Duration in ns. For a sample whose fields are recorded or
/// selected, the result is a std::optional, which is empty if the sample lacks one of the two fields. The
/// range of the result covers every value of a message.
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

/// Returns a builtin_interfaces/Time as a point in time since 1970-01-01 in UTC, as
/// std::chrono::system_clock and the stamps of SampleInfo count. A stamp of simulated time counts from the
/// beginning of the simulation. For a sample whose fields are recorded or selected the result is a
/// std::optional, as with to_duration().
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

/// Returns a duration as a message. Seconds are rounded down, so that the nanoseconds are never negative. If
/// the duration does not fit into `sec` (32 bits), the result is the nearest duration that does.
template <detail::OwnedSeconds Message>
constexpr Message duration_message(std::chrono::nanoseconds duration) {
  return detail::seconds_message<Message>(duration);
}

/// Returns a point in time as a message, like duration_message(); a 32-bit `sec` can represent times until
/// 2038-01-19.
template <detail::OwnedSeconds Message>
constexpr Message time_message(std::chrono::sys_time<std::chrono::nanoseconds> time) {
  return detail::seconds_message<Message>(time.time_since_epoch());
}

}  // namespace sft
