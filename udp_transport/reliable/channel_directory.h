// The channels of one writer: one channel for each process that the writer serves reliably. A registry has
// the channels of all writers of a transport, and finds the channel that an ack names.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <set>
#include <utility>
#include <vector>

#include "core/seam/address.h"
#include "core/sync/lock_order.h"
#include "core/sync/mutex.h"
#include "udp_transport/reliable/channel.h"

namespace sft::udp {

/// Any thread may call the functions.
class ChannelRegistry {
 public:
  void add(const std::shared_ptr<Channel>& channel);
  /// Returns the channel with that number; null if it does not exist any more.
  std::shared_ptr<Channel> find(std::uint32_t writer, std::uint32_t number);
  /// Returns the channels of that writer to destinations with that IP address.
  std::vector<std::shared_ptr<Channel>> find_at(std::uint32_t writer, const core::IpAddress& ip);

 private:
  core::Mutex mutex_ SFT_ACQUIRED_AFTER(core::lock_order::endpoint)
      SFT_ACQUIRED_BEFORE(core::lock_order::queues);
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::weak_ptr<Channel>> known_ SFT_GUARDED_BY(mutex_);
};

/// By destination: the readers that are served reliably, with any masks.
using ReliableReaders = std::map<const Destination*, std::set<core::EndpointId>>;

/// Must be used by the agent's thread only. The registry must outlive this object.
class ChannelDirectory {
 public:
  ChannelDirectory(std::uint32_t writer, std::shared_ptr<WriterTally> tally, ChannelRegistry& registry,
                   std::uint16_t ack_port, std::shared_ptr<const KeptMemory> memory = {})
      : writer_(writer),
        tally_(std::move(tally)),
        registry_(registry),
        ack_port_(ack_port),
        memory_(std::move(memory)) {}
  ~ChannelDirectory() { keep_to({}); }
  ChannelDirectory(const ChannelDirectory&) = delete;
  ChannelDirectory& operator=(const ChannelDirectory&) = delete;

  /// Returns the channel to these readers at that destination. A known channel continues if at least one of
  /// its readers is in `readers`. Otherwise a new channel is made.
  std::shared_ptr<Channel> find(const std::shared_ptr<Destination>& to,
                                const std::set<core::EndpointId>& readers);
  /// Returns true if at least one channel is faulty. find() replaces such a channel.
  bool any_channel_failed() const;
  /// Ends the channels to destinations that are not in `readers`.
  void keep_to(const ReliableReaders& readers);
  /// Returns true if channels were closed, or have ended, since the last call.
  bool take_closed() { return std::exchange(closed_, false); }

 private:
  std::uint32_t unused_number(const Destination& to);

  const std::uint32_t writer_;
  const std::shared_ptr<WriterTally> tally_;
  ChannelRegistry& registry_;
  const std::uint16_t ack_port_;
  const std::shared_ptr<const KeptMemory> memory_;
  std::uint32_t last_number_ = 0;  ///< the number of channels made so far, to all destinations
  /// The channel to a destination, and its readers. Routes and the sending thread own the channel. The
  /// channel keeps its destination alive.
  struct Known {
    std::weak_ptr<Channel> channel;
    std::set<core::EndpointId> readers;
  };
  std::map<const Destination*, Known> channels_;
  bool closed_ = false;
};

}  // namespace sft::udp
