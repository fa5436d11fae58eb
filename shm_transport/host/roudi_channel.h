// The way a process asks the daemon for ports: iceoryx's own protocol of datagrams, spoken with deadlines.
//
// iceoryx's client side (PoshRuntimeImpl) waits for answers without end and aborts where it gets none. This
// speaks the same words, but every call ends at its deadline, and an answer that comes later is recognised
// and undone.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "shm_transport/host/file_lock.h"
#include "shm_transport/host/iceoryx.h"

namespace sft::shm {

using Clock = std::chrono::steady_clock;

/// What the daemon tells a process that registers: where the management segment begins to make sense.
struct Registration {
  std::uint64_t management_bytes = 0;
  std::uint64_t management_id = 0;  ///< of the segment, in iceoryx's relative pointers
  std::uint64_t segment_manager_offset = 0;
};

/// Where a port lies, as the daemon answered. Bounds are the caller's to check.
struct PortPlace {
  std::uint64_t segment_id = 0;
  std::uint64_t offset = 0;
};

class RoudiChannel {
 public:
  /// Tells whether the port at that place is the one that was asked for under this label (in m_nodeName), so
  /// that an answer that missed its deadline is not taken for that of a later request. Undoes the port where
  /// it is not.
  using Claim = std::function<bool(const PortPlace& place, const std::string& label)>;

  /// Asks the daemon, which is of that account, to register this process under `runtime_name`; does not wait
  /// for the answer.
  static Result<std::unique_ptr<RoudiChannel>> open(const std::string& runtime_name, uid_t daemon_user);
  ~RoudiChannel();

  /// The answer to that, once it is there.
  Result<std::optional<Registration>> poll_registration();

  /// `remark`: stands behind the label, for others to read. Any thread; requests take turns, and waiting for
  /// one's turn counts towards the deadline.
  Result<PortPlace> create_publisher(const iox::capro::ServiceDescription& service,
                                     iox::popo::PublisherOptions options, const Claim& claim,
                                     Clock::time_point deadline);
  Result<PortPlace> create_subscriber(const iox::capro::ServiceDescription& service,
                                      iox::popo::SubscriberOptions options, const Claim& claim,
                                      Clock::time_point deadline, const std::string& remark = {});

  /// Tells the daemon that all that this process had may go. Does not wait.
  void say_goodbye() noexcept;

  const std::string& runtime_name() const { return runtime_name_; }

 private:
  class Turn;
  RoudiChannel(std::string runtime_name, Descriptor from_daemon, Descriptor to_daemon);
  Result<void> send(const iox::runtime::IpcMessage& message, Clock::time_point deadline);
  Result<iox::runtime::IpcMessage> receive(Clock::time_point deadline);
  Result<PortPlace> ask_for_port(iox::runtime::IpcMessage request, iox::runtime::IpcMessageType answer,
                                 const std::string& label, const Claim& claim, Clock::time_point deadline);
  std::string next_label();

  std::string runtime_name_;
  Descriptor from_daemon_;  ///< bound to /tmp/<runtime name>; the daemon answers there
  Descriptor to_daemon_;    ///< connected, so that it can never reach a later daemon
  std::int64_t registration_stamp_ = 0;

  std::mutex turn_mutex_;
  std::condition_variable turn_ends_;
  bool turn_taken_ = false;
  std::uint64_t requests_ = 0;
};

}  // namespace sft::shm
