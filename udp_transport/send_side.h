// What the writers of one transport share.
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "udp_transport/channel_directory.h"
#include "udp_transport/destination.h"
#include "udp_transport/multicast_group.h"
#include "udp_transport/multicast_links.h"
#include "udp_transport/sender.h"

namespace sft::udp {

/// What has something to do now and then, on the agent's thread.
class Tended {
 public:
  virtual void tend(std::chrono::steady_clock::time_point now) = 0;

 protected:
  ~Tended() = default;
};

/// Any thread.
class TendedRoster {
 public:
  void add(Tended& one) {
    const std::scoped_lock lock(mutex_);
    all_.push_back(&one);
  }
  /// Afterwards it is not called any more.
  void remove(Tended& one) {
    const std::scoped_lock lock(mutex_);
    std::erase(all_, &one);
  }
  void tend(std::chrono::steady_clock::time_point now) {
    const std::scoped_lock lock(mutex_);
    for (Tended* one : all_) one->tend(now);
  }

 private:
  std::mutex mutex_;
  std::vector<Tended*> all_;
};

/// Outlives the transport as long as a writer does.
struct SendSide {
  SendSide(std::unique_ptr<DatagramSender> io, const DestinationLimits& to_each,
           std::uint64_t max_bytes_per_s = 0)
      : sender(std::move(io), max_bytes_per_s),
        destinations(to_each, [this](const SocketAddress& to) { return sender.connect(to); }),
        limits(to_each) {}

  Sender sender;
  DestinationDirectory destinations;
  ChannelRoster channels;
  GroupRoster groups;
  TendedRoster writers;
  DestinationLimits limits;  ///< of groups
  Multicast multicast = Multicast::automatic;
  std::uint16_t ack_port = 0;        ///< where this transport receives
  std::size_t max_sample_bytes = 0;  ///< of a body
  std::size_t queue_depth = 0;
  std::atomic<std::uint64_t> over_limit{0};
};

}  // namespace sft::udp
