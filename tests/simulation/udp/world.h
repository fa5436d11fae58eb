// One writer, a process with some readers of it, and a network in between, from a seed: both ends of the
// protocol as they are, on simulated I/O and time. The world has the clock, and lets its parts act in turn.
// Its laws are checked after each event, and at the end.
#pragma once

#include <cstdint>
#include <string>

#include "tests/simulation/udp/channel_sender.h"
#include "tests/simulation/udp/group_path.h"
#include "tests/simulation/udp/laws.h"
#include "tests/simulation/udp/network.h"
#include "tests/simulation/udp/publisher.h"
#include "tests/simulation/udp/random.h"
#include "tests/simulation/udp/reader_host.h"
#include "tests/simulation/udp/scenario.h"

namespace sft::simulation {

class World {
 public:
  /// Where datagrams are forged, all samples are delivered again from a second after the last forgery on;
  /// those that were lost before are not counted.
  explicit World(std::uint64_t seed, Plan plan = Plan::usual);

  /// Runs until nothing happens any more. Returns the first violation of a law; empty if there is none.
  std::string run();

  /// How often readers have joined, left, or asked for something else.
  std::size_t changes() const { return readers_.changes(); }
  /// How many samples that have passed the conditions of all readers were sent to a group.
  std::size_t gated_by_group() const { return publisher_.gated_by_group(); }

 private:
  Time next_event() const;
  bool step();
  void deliver();
  void crash();
  void start_again();
  void publish();
  bool is_quiet() const { return publisher_.left() < scenario_.asking.quiet; }
  void churn();

  Random random_;
  const Scenario scenario_;
  Network network_;
  Laws laws_;
  ChannelSender channel_;
  GroupPath group_;
  Publisher publisher_;
  ReaderHost readers_;
  Time now_ = start_time;
  Time crash_at_ = Time::max();
  Time back_at_ = Time::max();
};

}  // namespace sft::simulation
