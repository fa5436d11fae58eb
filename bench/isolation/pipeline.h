// The processes of one contender: the sensors' program and three readers on host 0, and a reader on host 1.
// The topics "camera" and "lidar" carry samples of 6.3 MB in turns. Each reader reads both topics.
#pragma once

#include <sys/types.h>

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "bench/common/contender.h"
#include "bench/common/host_processes.h"
#include "bench/common/shared.h"
#include "bench/isolation/contender.h"
#include "bench/isolation/observation.h"

namespace sft::bench::isolation {

class Pipeline {
 public:
  static constexpr std::size_t remote_host = 1;

  /// Starts all processes except the remote reader.
  Pipeline(const Contender& contender, std::shared_ptr<const hosts::EmulatedNetwork> network, double rate_hz);

  bool is_ready() const { return board_->ready.load() == 1 + local_readers; }
  void begin() { board_->begun = true; }

  void start_remote();
  /// Sends a signal to the remote reader's process. REQUIRES: the process was started.
  void signal_remote(int signal) const;

  const Board& board() const { return *board_; }
  /// Returns the present time, and the processor time that the processes have used so far.
  Resources resources() const;

 private:
  int write_all() const;
  int read_all(std::size_t reader) const;
  void write_in_turns(const std::vector<std::unique_ptr<Writer>>& writers) const;
  Arrived note_arrivals(std::size_t reader) const;

  const Contender contender_;
  const std::int64_t period_ns_;
  const Shared<Board> board_;
  HostProcesses processes_;
  std::array<pid_t, 1 + local_readers> local_{};
  pid_t remote_ = 0;  ///< process id of the remote reader; 0: the process was not started
};

}  // namespace sft::bench::isolation
