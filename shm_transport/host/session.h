// One registration of this process with one daemon. A session has the mappings of the daemon's memory and
// the channel for requests to the daemon. It also undoes everything that depends on the daemon when the
// daemon is gone.
//
// Lifetime: every object that uses a session, including each sample, shares the ownership of the session.
// The mappings end with the last owner. So a sample can be read until its last handle is gone, even if the
// daemon, the node or the transport is gone.
//
// Loss of the daemon: iceoryx resolves the relative pointers inside its segments by one table for each
// process, from segment ids to addresses, and the next daemon uses the same ids. So lose() must be called
// before another session can begin. lose() notifies every port of this session that it must not use iceoryx
// any more. From then on the ports only give out and take back samples that are already mapped. Then it
// removes the segments of this session from the table.
#pragma once

#include <atomic>
#include <memory>
#include <string>
#include <vector>

#include "core/platform/forked.h"
#include "core/seam/transport.h"
#include "core/sync/mutex.h"
#include "shm_transport/host/chunk_pools.h"
#include "shm_transport/host/host_file.h"
#include "shm_transport/host/mapping.h"
#include "shm_transport/host/queue_wishes.h"
#include "shm_transport/host/roudi_channel.h"
#include "shm_transport/host/session_member.h"

namespace sft::shm {

class IceoryxRuntime;

class Session : public std::enable_shared_from_this<Session> {
 public:
  /// Maps the segments of the daemon that answered. `runtime` keeps iceoryx usable in this process.
  static Result<std::shared_ptr<Session>> open(std::shared_ptr<IceoryxRuntime> runtime, HostMonitor monitor,
                                               std::unique_ptr<RoudiChannel> channel,
                                               const Registration& registration);
  ~Session();

  const core::HostToken& token() const { return token_; }
  /// Returns whether this process may write samples. If not, this process may only read the samples of
  /// other processes.
  bool can_write() const { return can_write_; }
  pid_t daemon_pid() const { return monitor_.file().pid; }
  bool daemon_lives() const noexcept { return monitor_.daemon_lives(); }

  Result<iox::popo::PublisherPortData*> create_publisher(core::EndpointId writer,
                                                         const RoudiChannel::Timeouts& timeouts);
  /// Makes a subscriber port. With `depth` 0 the port is not subscribed: it is only a list of held chunks,
  /// which the daemon frees when this process dies. `wishes` are the requests of the reader to the writer.
  Result<iox::popo::SubscriberPortData*> create_subscriber(core::EndpointId writer, std::uint32_t depth,
                                                           const RoudiChannel::Timeouts& timeouts,
                                                           const QueueWishes& wishes = {});
  /// Returns the result of RoudiChannel::awaits_answer().
  bool awaits_answer() const { return channel_->awaits_answer(); }
  /// Returns the port that has this queue; null if no port has it. Searches all queues of the host.
  const iox::popo::SubscriberPortData* port_of(
      const iox::popo::SubscriberPortData::ChunkQueueData_t& queue) const noexcept;
  /// Allows every process that may write samples to ring the doorbells in a page of this process
  /// (core/platform/doorbell.h). The group of the page shows writers that the daemon serves the owner of
  /// the page.
  void admit_writers(std::uint64_t doorbell_page) const;
  /// Returns the accounts that the daemon serves. A writer rings only the doorbells of these accounts. Each
  /// of these accounts could also truncate the daemon's own memory, so opening their pages of doorbells
  /// adds no risk.
  core::TrustedAccounts reader_accounts() const;
  /// Returns the pools from which the writers of this process take chunks. A session has one such set of
  /// pools.
  ChunkPools& pools(const iox::mepoo::MemoryManager& pools);
  /// Maps chunks that writers of this process will probably take next (prepared_chunks.h). Called at each
  /// poll.
  void prepare_chunks() noexcept;
  /// Returns the port of the writer that delivers into the queue of this port; null if there is no such
  /// writer. Searches all writers of the host.
  const iox::popo::PublisherPortData* feeder_of(const iox::popo::SubscriberPortData& port) const noexcept;
  /// Returns whether `feeder`, an earlier result of feeder_of(), still delivers into this queue. Reads only
  /// the entry of `feeder` in the daemon's table. By now that entry may have no port, or another port.
  static bool feeds(const iox::popo::PublisherPortData& feeder,
                    const iox::popo::SubscriberPortData& port) noexcept;
  /// Takes over a port that is not used any more, to give it back to the daemon later. Call unsubscribe()
  /// of the port before.
  void retire(iox::popo::SubscriberPortData* port);
  /// Gives back the retired ports to which no writer delivers any more. Returns at once. Called at each
  /// poll.
  void collect();

  /// Returns whether these bytes are within the segments of samples.
  bool holds(const void* data, std::size_t size) const;

  /// Adds a member. SessionMember::lose() is called when the session is lost, or at once if the session is
  /// lost already.
  void enlist(const std::shared_ptr<SessionMember>& member);
  void lose() noexcept;

 private:
  struct Segment {
    std::uint64_t id;
    Mapping mapping;
  };
  Session(std::shared_ptr<IceoryxRuntime> runtime, HostMonitor monitor,
          std::unique_ptr<RoudiChannel> channel);
  Result<void> map(const Registration& registration);
  Result<void> add_segment(std::uint64_t id, const std::string& name, std::size_t bytes, bool writable);
  Result<void> add_samples();
  RoudiChannel::TakePort take_port() const;
  template <class PortData>
  Result<PortData*> answered_port(const Result<PortLocation>& location) const;
  void forget_segments() noexcept;
  const iox::roudi::PortPoolData* port_pool() const;
  iox::popo::BasePortData* port_at(const PortLocation& location, std::size_t bytes) const;

  const core::OfOneProcess of_one_process_;
  std::shared_ptr<IceoryxRuntime> runtime_;
  HostMonitor monitor_;
  std::unique_ptr<RoudiChannel> channel_;
  core::HostToken token_;
  std::vector<Segment> segments_;  ///< the management segment comes first
  bool can_write_ = true;

  core::Mutex mutex_;
  bool lost_ SFT_GUARDED_BY(mutex_) = false;
  std::vector<std::weak_ptr<SessionMember>> members_ SFT_GUARDED_BY(mutex_);
  std::vector<iox::popo::SubscriberPortData*> retired_ SFT_GUARDED_BY(mutex_);
  std::unique_ptr<ChunkPools> pools_ SFT_GUARDED_BY(mutex_);
};

}  // namespace sft::shm
