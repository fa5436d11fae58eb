// Two processes that pass messages, each pinned to a core. All measurements of latency have this form.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <vector>

namespace sft::bench {

/// Returns nanoseconds of CLOCK_MONOTONIC, which processes of one machine can compare.
inline std::int64_t now_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

/// The data in memory that the two processes share.
class Exchange {
 public:
  static constexpr std::size_t samples_max = 20'000;

  alignas(64) std::atomic<std::uint64_t> sent{0};      ///< number of the last message that was sent
  alignas(64) std::atomic<std::uint64_t> received{0};  ///< number of the last message that was read
  alignas(64) std::atomic<bool> ready{false};          ///< true once the receiver has begun
  std::atomic<bool> failed{false};
  std::int64_t sent_at[samples_max] = {};
  /// By message: the time at which the sending function returned; 0: not noted.
  std::int64_t returned_at[samples_max] = {};
  std::int64_t received_at[samples_max] = {};

  /// Called by the sender. Waits until the receiver has read message n. Returns false if that takes more
  /// than a second.
  bool wait_for_receipt(std::uint64_t n);
  /// Notes that the receiver has read message n. Called by the receiver.
  void note_receipt(std::uint64_t n);
};

/// The functions that the two processes run. Each process first calls `enter`, for example to join a
/// namespace.
struct Sides {
  std::function<void(Exchange&)> sender;
  std::function<void(Exchange&)> receiver;
  std::function<void()> enter_sender = [] {};
  std::function<void()> enter_receiver = [] {};
};

/// The times of a message.
struct Delivery {
  std::int64_t sent_at = 0;
  std::int64_t received_at = 0;  ///< time of the receipt; 0: the message was not read
  std::int64_t returned_at = 0;  ///< time when the function that sent the message returned; 0: not noted

  double us() const { return static_cast<double>(received_at - sent_at) / 1000.0; }
};

/// Runs both sides until they return, and returns the times of all messages. Empty if a side failed.
std::vector<Delivery> run_deliveries(const Sides& sides, std::uint64_t messages);
/// Runs both sides until they return. Returns the one-way times in microseconds of the messages that were
/// read, without the first tenth. Empty if a side failed.
std::vector<double> run_pair(const Sides& sides, std::uint64_t messages);

/// Waits for this time without sleeping, which keeps this core out of deep idle states. The time should be
/// so long that the receiver falls asleep between two messages.
void pause_us(std::int64_t us);
/// Sleeps for this time, and leaves the core to other threads.
void sleep_us(std::int64_t us);
/// Sleeps until now_ns() returns `ns`.
void sleep_until(std::int64_t ns);
/// Calls `holds` every millisecond until it returns true, and then returns true. Returns false after the
/// timeout.
bool wait_until(const std::function<bool()>& holds, double timeout_s = 20);

}  // namespace sft::bench
