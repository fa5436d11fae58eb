// Two processes, each pinned to a core, that pass something back and forth: the shape of every latency
// measurement here.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <vector>

namespace sft::bench {

/// Nanoseconds of CLOCK_MONOTONIC, comparable between processes of one machine.
inline std::int64_t now_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

/// Shared by the two processes.
class Exchange {
 public:
  static constexpr std::size_t samples_max = 20'000;

  alignas(64) std::atomic<std::uint64_t> sent{0};      ///< number of the message under way
  alignas(64) std::atomic<std::uint64_t> received{0};  ///< number of the last one that was read
  alignas(64) std::atomic<bool> ready{false};          ///< the receiver has begun
  std::atomic<bool> failed{false};
  std::int64_t sent_at[samples_max] = {};
  std::int64_t received_at[samples_max] = {};

  /// The sender: waits until the receiver has read message n; gives up after a second.
  bool wait_for_receipt(std::uint64_t n);
  /// The receiver: it has read message n now.
  void note_receipt(std::uint64_t n);
};

/// Where each side runs, and how: `enter` is called in the process before its role (to join a namespace,
/// say).
struct Sides {
  std::function<void(Exchange&)> sender;
  std::function<void(Exchange&)> receiver;
  std::function<void()> enter_sender = [] {};
  std::function<void()> enter_receiver = [] {};
};

/// Runs both sides to their end and returns the one-way times in microseconds of the messages that were read,
/// without the first tenth. Empty if a side failed.
std::vector<double> run_pair(const Sides& sides, std::uint64_t messages);

/// Lets the receiver fall asleep between two messages, without this core going into a deep idle state.
void pause_us(std::int64_t us);
/// Leaves the core to others meanwhile.
void sleep_us(std::int64_t us);
/// Looks every millisecond, for what sides that start wait for; false after 20 s.
bool wait_until(const std::function<bool()>& holds);

}  // namespace sft::bench
