// Sends the messages of one size, and measures them: first one by one, then as fast as possible.
#pragma once

#include <cstdint>

#include "bench/common/contender.h"
#include "bench/peers/board.h"
#include "bench/peers/entrant.h"
#include "bench/peers/pace.h"

namespace sft::bench::peers {

class Sender {
 public:
  /// `size` is the index of the size. All arguments must outlive the sender.
  Sender(Board& board, Writer& writer, std::size_t size, const Case& of, const Pace& pace);

  /// Measures, and writes the results to the board. Returns false if the readers do not receive the last
  /// message.
  bool measure();

 private:
  struct Moment {
    std::int64_t at_ns;
    std::uint64_t received;
    double cpu_s;
  };

  bool sleeps() const { return of_.waiting == Waiting::sleeping; }
  Moment moment() const;
  /// The first function returns the number of messages that every reader has received. The second one
  /// returns the greatest number that every reader has received.
  std::uint64_t received() const;
  std::uint64_t last_received() const;
  /// Returns when the last of the readers received a message.
  std::int64_t received_at_ns(std::uint64_t number) const;

  /// Sends a message, and waits until it has arrived and the period is over. Returns the time until it
  /// arrived in microseconds; NaN if it has not arrived.
  double send_and_wait();
  void warm_up();
  void measure_latency();
  void send_for(double seconds);
  void measure_throughput();
  void count_lost();
  bool finish();

  Board& board_;
  Writer& writer_;
  const std::size_t size_;
  const Case of_;
  const Pace pace_;
  SizeResult& result_;
  std::uint64_t number_ = 0;
};

}  // namespace sft::bench::peers
