// A simulation from one seed: a writer, a process with some of its readers, and a network in between. Both
// ends of the protocol are the real code, with simulated I/O and time. The world has the clock, and calls its
// parts in turn. It checks the laws after each event and at the end.
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
  /// If datagrams are forged, all samples must arrive that are published later than a second after the last
  /// forgery. Earlier samples may be lost.
  explicit World(std::uint64_t seed, Plan plan = Plan::usual);

  /// Runs until there are no more events. Returns the first violation of a law, or "" if there is none.
  std::string run();

  /// Returns the number of times that readers have joined, left, or changed their wishes.
  std::size_t changes() const { return readers_.changes(); }
  /// Returns the number of samples that have passed a gate and were sent to a group.
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
