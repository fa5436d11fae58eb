// Asks the daemon for ports, with the messages of iceoryx's own protocol.
//
// The client of iceoryx (PoshRuntimeImpl) waits for answers without end, and aborts the process if there is
// an error. This class sends the same messages, but each call ends at its deadline. If an answer comes later,
// a later call recognises it and gives the port back.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "core/sync/mutex.h"
#include "shm_transport/host/file_lock.h"
#include "shm_transport/host/iceoryx.h"

namespace sft::shm {

using Clock = std::chrono::steady_clock;

/// The answer of the daemon to a process that has registered: the segment that manages all others.
struct Registration {
  std::uint64_t management_bytes = 0;
  std::uint64_t management_id = 0;  ///< the segment's number in iceoryx's relative pointers
  std::uint64_t segment_manager_offset = 0;
};

/// The location of a port in shared memory, as the daemon answered it. The caller must check the bounds.
struct PortLocation {
  std::uint64_t segment_id = 0;
  std::uint64_t offset = 0;
};

class RoudiChannel {
 public:
  /// Returns whether the port at this location was requested with this label (in m_nodeName), and gives the
  /// port back if it was not. So an answer that missed its deadline is not taken for the answer to a later
  /// request.
  using Claim = std::function<bool(const PortLocation& location, const std::string& label)>;

  /// Asks the daemon to register this process under `runtime_name`, and does not wait for the answer.
  /// `daemon_user`: the account of the daemon.
  static Result<std::unique_ptr<RoudiChannel>> open(const std::string& runtime_name, uid_t daemon_user);
  ~RoudiChannel();

  /// Returns the answer to the registration, or nothing if it has not come yet.
  Result<std::optional<Registration>> poll_registration();

  /// `remark`: a text behind the label, which other processes can read. Any thread. Requests take turns; the
  /// time until a request has its turn counts towards its deadline.
  Result<PortLocation> create_publisher(const iox::capro::ServiceDescription& service,
                                        iox::popo::PublisherOptions options, const Claim& claim,
                                        Clock::time_point deadline);
  Result<PortLocation> create_subscriber(const iox::capro::ServiceDescription& service,
                                         iox::popo::SubscriberOptions options, const Claim& claim,
                                         Clock::time_point deadline, const std::string& remark = {});

  /// Tells the daemon to remove everything that this process has there. Does not wait.
  void say_goodbye() noexcept;

 private:
  class Turn;
  RoudiChannel(std::string runtime_name, Descriptor from_daemon, Descriptor to_daemon);
  Result<void> send(const iox::runtime::IpcMessage& message, Clock::time_point deadline);
  Result<iox::runtime::IpcMessage> receive(Clock::time_point deadline);
  Result<PortLocation> ask_for_port(iox::runtime::IpcMessage request, iox::runtime::IpcMessageType answer,
                                    const std::string& label, const Claim& claim, Clock::time_point deadline);
  std::string next_label();

  std::string runtime_name_;
  Descriptor from_daemon_;  ///< bound to /tmp/<runtime name>, where the daemon answers
  Descriptor to_daemon_;    ///< connected, so that no message can reach a later daemon
  std::int64_t registration_stamp_ = 0;

  core::Mutex turn_mutex_;
  core::Condition turn_ends_;
  bool turn_taken_ SFT_GUARDED_BY(turn_mutex_) = false;  ///< a request is under way
  std::uint64_t requests_ SFT_GUARDED_BY(turn_mutex_) = 0;
};

}  // namespace sft::shm
