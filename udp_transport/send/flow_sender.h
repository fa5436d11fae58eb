// Sends as much of a flow (the sample that a lane or channel is sending) as its destination and the rate
// limits allow. Schedules the time at which the sending thread continues with the flow.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <utility>

#include "udp_transport/flow/rate_limit.h"
#include "udp_transport/io/datagram_io.h"
#include "udp_transport/outgoing/wake.h"
#include "udp_transport/send/local_turns.h"
#include "udp_transport/send/next_round.h"
#include "udp_transport/send/send_flow.h"

namespace sft::udp {

/// All functions must be called by the sending thread.
class FlowSender {
 public:
  using Time = SendFlow::Time;
  enum class Progress : std::uint8_t {
    none,   ///< no data was sent: the flow has to wait
    some,   ///< a part of the sample was sent, and the rest has to be sent later
    whole,  ///< the whole sample was sent
    lost,
  };
  static bool is_under_way(Progress progress) {
    return progress == Progress::none || progress == Progress::some;
  }
  /// If the connection of a flow is full for longer than this, the sample is given up. The memory is needed
  /// for other samples, and a receiver of a part of the sample has given it up by then.
  static constexpr std::chrono::seconds timeout{2};

  /// `limit` is the common rate limit of all writers. All arguments must outlive this object.
  FlowSender(RateLimit& limit, LocalTurns& local_turns, DatagramSender& io, NextRound& round)
      : limit_(limit), local_turns_(local_turns), io_(io), round_(round) {}

  using Hear = std::function<Wake(std::span<const std::byte> datagram, const SocketAddress& from, Time now)>;
  /// Sets the function that handles answers (acks and reports). If it is empty, answers are ignored. Must be
  /// called before the sending thread begins.
  void set_handler(Hear hear) { hear_ = std::move(hear); }
  /// Reads and handles the answers that have come to the socket for answers, without waiting.
  void listen();

  /// Sends the data that may be sent in one turn, by several system calls. Handles answers
  /// between these calls, so that the sample is sent without a pause if answers come in time, and yields to
  /// readers on this host.
  Progress send_some(SendFlow& flow);
  /// Sends the data that may be sent by one system call.
  Progress send_a_few(SendFlow& flow, Time now);

 private:
  std::size_t cut_batches(SendFlow& flow, Time now);
  void wait_for_allowance(SendFlow& flow, Time now);
  void account_for(SendFlow& flow, Connection& by, std::size_t batches, Time now);
  Progress wait_for_room(SendFlow& flow, Connection& by, Time now);

  static constexpr int calls_per_turn = 8;  ///< number of system calls before the next flow has its turn
  static constexpr std::size_t batches_per_call = 8;
  /// The maximum size of one system call, in socket bytes. Data of this size is still in the nearest caches
  /// when the kernel copies it. The first of several such calls wakes a sleeping receiver early.
  static constexpr std::size_t bytes_per_call = batch_bytes_max;

  RateLimit& limit_;
  LocalTurns& local_turns_;
  DatagramSender& io_;
  NextRound& round_;
  Hear hear_;
  // The batches of the present system call.
  std::array<Batch, batches_per_call> batches_;
  std::array<OutgoingBatch, batches_per_call> outgoing_;
  /// For each batch, the state of the fragmenter after that batch was cut.
  std::array<std::optional<Fragmenter>, batches_per_call> rest_;
};

}  // namespace sft::udp
