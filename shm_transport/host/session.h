// One registration of this process with one daemon: the mappings of its memory, the channel to ask it for
// ports, and what has to be undone when it is gone.
//
// Lifetime: shared by everything that uses it, down to the single sample. The mappings go with the last of
// them, so a sample can be read until its last handle is gone, whatever happened to the daemon, the node or
// the transport.
//
// Losing the daemon. iceoryx resolves the relative pointers inside its segments through one table per
// process, from segment id to address, and the next daemon uses the same ids. So before another session can
// begin, lose() tells every port of this one to never touch iceoryx again (after that they only give out and
// take back what is mapped already) and takes this session's segments out of the table.
#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "core/platform/forked.h"
#include "core/seam/transport.h"
#include "shm_transport/host/chunk_pools.h"
#include "shm_transport/host/host_file.h"
#include "shm_transport/host/roudi_channel.h"

namespace sft::shm {

class IceoryxRuntime;

/// A port's state, which must not use iceoryx any more once the session is lost.
class SessionMember {
 public:
  /// Returns after the last use of iceoryx under way in another thread.
  virtual void lose() noexcept = 0;

 protected:
  ~SessionMember() = default;
};

/// What a queue's reader asks of the writer, in the name of its port.
struct QueueWishes {
  core::EndpointId reader = 0;  ///< 0: it asks for nothing
  bool late = false;            ///< what is retained comes before all else
  bool awaited = false;         ///< the writer waits for room in the queue, as long as it may
};

/// A segment of shared memory in this process.
class Mapping {
 public:
  /// Of a segment that belongs to `owner`, the daemon's account: another one could make it shorter.
  static Result<Mapping> open(const std::string& name, std::size_t bytes, bool writable, uid_t owner);
  Mapping(Mapping&& other) noexcept : memory_(std::exchange(other.memory_, {})), group_(other.group_) {}
  Mapping& operator=(Mapping&&) = delete;
  ~Mapping();

  std::span<std::byte> bytes() const { return memory_; }
  gid_t group() const { return group_; }  ///< of the file
  bool contains(const void* data, std::size_t size) const;

 private:
  Mapping(std::span<std::byte> memory, gid_t group) : memory_(memory), group_(group) {}
  std::span<std::byte> memory_;
  gid_t group_;
};

class Session : public std::enable_shared_from_this<Session> {
 public:
  /// Maps the segments of the daemon that answered. `runtime` is what keeps iceoryx usable in this process.
  static Result<std::shared_ptr<Session>> open(std::shared_ptr<IceoryxRuntime> runtime, HostWatch watch,
                                               std::unique_ptr<RoudiChannel> channel,
                                               const Registration& registration);
  ~Session();

  const core::HostToken& token() const { return token_; }
  /// Whether this process may write samples, or only read those of others.
  bool can_write() const { return can_write_; }
  pid_t daemon_pid() const { return watch_.file().pid; }
  bool daemon_lives() const noexcept { return watch_.daemon_lives(); }

  Result<iox::popo::PublisherPortData*> create_publisher(core::EndpointId writer, Clock::time_point deadline);
  /// `depth` 0: not subscribed, only a list of held chunks that the daemon frees when this process dies.
  /// `wishes`: what the writer is to know of the queue's reader.
  Result<iox::popo::SubscriberPortData*> create_subscriber(core::EndpointId writer, std::uint32_t depth,
                                                           Clock::time_point deadline,
                                                           const QueueWishes& wishes = {});
  /// The port that has this queue, or null. Looks at all queues of the host.
  const iox::popo::SubscriberPortData* port_of(
      const iox::popo::SubscriberPortData::ChunkQueueData_t& queue) const noexcept;
  static QueueWishes wishes_of(const iox::popo::SubscriberPortData& port) noexcept;
  /// Lets all that may write samples ring in a page of this process's (core/platform/doorbell.h), and see by
  /// its group that it is of somebody whom the daemon serves.
  void admit_writers(std::uint64_t doorbell_page) const;
  /// Whom the daemon serves: whose doorbells may be rung. Each of them could also make the daemon's own
  /// memory shorter, so that a page of theirs takes no more trust than that does.
  core::TrustedAccounts reader_accounts() const;
  /// The pools that its writers take from, of which this process sees one set.
  ChunkPools& pools(const iox::mepoo::MemoryManager& pools);
  /// The writer's port that delivers into this port's queue, or null. Looks at all writers of the host.
  const iox::popo::PublisherPortData* feeder_of(const iox::popo::SubscriberPortData& port) const noexcept;
  /// Whether the port that was found so still does. Looks only there, where by now there may be none or
  /// another.
  static bool feeds(const iox::popo::PublisherPortData& feeder,
                    const iox::popo::SubscriberPortData& port) noexcept;
  /// Gives a port back that nobody uses any more. It must have been asked to unsubscribe.
  void retire(iox::popo::SubscriberPortData* port);
  /// Destroys retired ports that no writer feeds any more. Returns at once; called now and then.
  void collect();

  /// Whether these bytes are within the segments that samples lie in.
  bool holds(const void* data, std::size_t size) const;

  /// From now on the member is told when the session is lost, or at once if it is.
  void enlist(const std::shared_ptr<SessionMember>& member);
  void lose() noexcept;

 private:
  struct Segment {
    std::uint64_t id;
    Mapping mapping;
  };
  Session(std::shared_ptr<IceoryxRuntime> runtime, HostWatch watch, std::unique_ptr<RoudiChannel> channel);
  Result<void> map(const Registration& registration);
  Result<void> add_segment(std::uint64_t id, const std::string& name, std::size_t bytes, bool writable);
  Result<void> add_samples();
  void forget_segments() noexcept;
  const iox::roudi::PortPoolData* port_pool() const;
  iox::popo::BasePortData* port_at(const PortPlace& place, std::size_t bytes) const;
  bool claim(const PortPlace& place, const std::string& label) const;

  const core::OfOneProcess of_one_process_;
  std::shared_ptr<IceoryxRuntime> runtime_;
  HostWatch watch_;
  std::unique_ptr<RoudiChannel> channel_;
  core::HostToken token_;
  std::vector<Segment> segments_;  ///< the management segment first
  bool can_write_ = true;

  std::mutex mutex_;  // guards what follows
  bool lost_ = false;
  std::vector<std::weak_ptr<SessionMember>> members_;
  std::vector<iox::popo::SubscriberPortData*> retired_;
  std::unique_ptr<ChunkPools> pools_;
};

}  // namespace sft::shm
