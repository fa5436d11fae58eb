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
  /// `forgers`: datagrams are forged, too, in the beginning. All samples are delivered again from a second
  /// after the last forgery on; those that were lost before are not counted.
  explicit World(std::uint64_t seed, bool forgers = false);

  /// Runs until nothing happens any more. Returns the first violation of a law; empty if there is none.
  std::string run();

 private:
  Time next_event() const;
  bool step();
  void deliver();
  void crash();
  void start_again();
  void publish();

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
