// What the roles, each in a process of its own, tell the demo, and what the demo orders the lidar to do, in
// memory that all of them share.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <type_traits>

namespace sft::demo {

using Clock = std::chrono::steady_clock;

inline constexpr const char* topic = "points";
inline constexpr std::chrono::milliseconds between_reports{100};

/// A text in shared memory. What is too long is cut off.
template <std::size_t Bytes>
class Text {
 public:
  Text& operator=(std::string_view text) {
    std::fill(std::begin(chars_), std::end(chars_), '\0');
    text.copy(chars_, Bytes - 1);
    return *this;
  }
  std::string str() const { return chars_; }

 private:
  char chars_[Bytes] = {};
};

/// A subscriber as the lidar serves it.
struct Route {
  Text<16> name;
  bool served = false;
  bool in_shared_memory = false;  ///< otherwise by UDP
  Text<256> reason;               ///< why so, or why it is not served
  Text<256> fields;               ///< those that it asks for: "header, data{x,y,z}"
  bool all_fields = false;
  double max_rate_hz = 0;      ///< 0: all clouds
  std::uint64_t withheld = 0;  ///< clouds that were not sent, since it asks for a lower rate
};

struct PublisherReport {
  std::uint64_t published = 0;
  bool finished = false;   ///< nothing remains to be published
  double whole_bytes = 0;  ///< of a cloud with all fields, encapsulation included, on average
  std::array<Route, 8> routes{};
};

struct SubscriberReport {
  bool open = false;
  std::uint64_t received = 0;
  std::uint64_t lost = 0;
  std::int64_t bytes = 0;           ///< of all clouds: on the wire where that is measured, else their payload
  std::int64_t learning_bytes = 0;  ///< those of them that came before the recorded fields were known
  std::uint64_t steady_samples = 0;  ///< clouds since then
  std::int64_t steady_bytes = 0;
  double latency_p50_us = 0;  ///< 0: nothing was received
  double latency_p99_us = 0;
};

/// A report in shared memory. One process writes it, and the demo reads it.
template <class Report>
class Posted {
 public:
  void write(const Report& report) {
    static_assert(std::is_trivially_copyable_v<Report>);
    while (busy_.test_and_set(std::memory_order_acquire)) continue;  // the demo copies it
    report_ = report;
    busy_.clear(std::memory_order_release);
  }
  /// Leaves `report` as it is while the report is being written.
  void read(Report& report) {
    if (busy_.test_and_set(std::memory_order_acquire)) return;
    report = report_;
    busy_.clear(std::memory_order_release);
  }

 private:
  std::atomic_flag busy_;
  Report report_{};
};

/// `end` is for all roles, the others are for the lidar.
enum class Order : std::uint8_t { none, publish, halt, end };

struct Board {
  std::atomic<Order> order{Order::none};
  Posted<PublisherReport> publisher;
  std::array<Posted<SubscriberReport>, 5> subscribers;
};

}  // namespace sft::demo
