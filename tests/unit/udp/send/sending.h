// The parts of the sending thread, without the thread. Tests use these parts to send, but no datagram is
// sent to the network.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

#include "tests/unit/udp/connections.h"
#include "tests/unit/udp/jobs.h"
#include "udp_transport/flow/destination_directory.h"
#include "udp_transport/send/flow_sender.h"
#include "udp_transport/send/scheduled_work.h"

namespace sft::udp::test {

inline constexpr std::size_t small_bytes = 100, large_bytes = 300'000;  // sizes of samples in bytes

struct Sending {
  Sending() { to->set_receive_buffer(roomy); }

  std::shared_ptr<Lane> lane(Lane::Start start = Lane::Start::open, std::shared_ptr<Channel> through = {}) {
    return std::make_shared<Lane>(to, 100, tally, start, std::move(through));
  }
  std::shared_ptr<Channel> channel() { return std::make_shared<Channel>(1, 1, to, tally, 7); }
  JobHandle job(std::size_t bytes) { return make_job(*jobs, ++sequence, bytes); }
  std::size_t bytes_left() const {
    std::size_t bytes = 0;
    for (const Bytes& datagram : connections.sent()) bytes += datagram.size();
    return bytes;
  }

  /// The size of a flow window in bytes that is larger than all data of a test.
  static constexpr std::uint32_t roomy = 256 << 20;

  std::shared_ptr<JobPool> jobs = JobPool::make();
  std::uint64_t sequence = 0;
  Connections connections;
  DestinationDirectory destinations{{.datagram_bytes = 1472, .flow = {.first_bytes = roomy}},
                                    connections.connect()};
  std::shared_ptr<Destination> to = destinations.find({.ip = 0x7F000001, .port = 1});
  std::shared_ptr<WriterTally> tally = std::make_shared<WriterTally>();
  NoSender io{connections};
  RateLimit limit{0};
  NextRound round;
  LocalTurns local_turns;
  FlowSender sender{limit, local_turns, io, round};
  ScheduledWork scheduled{io};
};

}  // namespace sft::udp::test
