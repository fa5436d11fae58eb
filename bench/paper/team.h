// One contender in one session: a writer's process on its host, and a reader's process on each of the other
// hosts.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <vector>

#include "bench/common/host_processes.h"
#include "bench/common/shared.h"
#include "bench/paper/messages.h"
#include "bench/paper/record.h"
#include "bench/paper/schedule.h"

namespace sft::bench::paper {

/// A phase: messages of one type on their own topic.
struct Phase {
  Case of;
  SharedMessages messages;
  std::array<FieldSet, receivers_max> needed{};  ///< the fields that each receiver needs
};

inline constexpr std::size_t phases_max = 8;
inline constexpr std::size_t samples_max = 512;

/// The notes of all processes of a team, which the parent process reads.
struct Board {
  /// Number of processes whose writers or readers are all matched.
  std::atomic<std::size_t> ready{0};
  /// Time of the beginning of the schedule; 0: not known yet.
  std::atomic<std::int64_t> begin_ns{0};
  /// By phase: number of messages written, including those that are not counted.
  std::atomic<std::size_t> written[phases_max] = {};
  std::int64_t due_ns[phases_max][samples_max] = {};
  std::int64_t sent_ns[phases_max][samples_max] = {};
  /// Time of the receipt; 0: not received.
  std::int64_t received_ns[phases_max][receivers_max][samples_max] = {};
};

/// The resources that a team has used up to a moment.
struct Used {
  double s = 0;  ///< the time of that moment
  double sender_bytes = 0;
  std::array<double, receivers_max> receiver_bytes{};
  double cpu_s = 0;

  Used operator-(const Used& before) const;
};

class Team {
 public:
  /// The task of a team: the number of its receivers, the phases, and the times of sending. `phases` must
  /// outlive the team.
  struct Task {
    std::size_t receivers;
    const std::vector<Phase>& phases;
    Pace pace;
    std::size_t slots;  ///< number of slots in each period
  };
  static constexpr std::size_t silent = SIZE_MAX;

  /// Starts the processes. `slot` is the team's slot in each period. A team that is `silent` writes no
  /// messages.
  Team(const Contender& contender, std::shared_ptr<const hosts::EmulatedNetwork> network, const Task& task,
       std::size_t slot);

  bool is_ready() const { return board_->ready.load() == task_.receivers + 1; }
  void begin(std::int64_t begin_ns) { board_->begin_ns = begin_ns; }

  Used used() const;
  double resident_bytes() const { return processes_.resident_bytes(); }
  const Board& board() const { return *board_; }
  const Contender& contender() const { return contender_; }
  bool is_silent() const { return slot_ == silent; }

 private:
  int write_all() const;
  Topic topic_of(std::size_t phase) const;
  void write_phase(std::size_t phase, Writer& writer, const Schedule& schedule) const;
  int read_all(std::size_t receiver) const;
  Arrived note_arrivals(std::size_t phase, std::size_t receiver) const;

  const Contender contender_;
  const Task task_;
  const std::size_t slot_;
  const Shared<Board> board_;
  HostProcesses processes_;
};

}  // namespace sft::bench::paper
