// Asks the daemon for ports, with the messages of iceoryx's own protocol.
//
// The client of iceoryx (PoshRuntimeImpl) waits for answers without a limit, and aborts the process if there
// is an error. This class sends the same messages, but each call waits for a moment only. An answer that
// comes later is kept for the call that asks for the same port again. If the answer is overdue, or if no call
// asks for the port again, the port is given back.
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
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
  using TakePort = std::function<bool(const PortLocation& location, const std::string& label)>;

  /// Asks the daemon to register this process under `runtime_name`, and does not wait for the answer.
  /// `daemon_user`: the account of the daemon.
  static Result<std::unique_ptr<RoudiChannel>> open(const std::string& runtime_name, uid_t daemon_user);
  ~RoudiChannel();

  /// Returns the answer to the registration, or nothing if it has not come yet.
  Result<std::optional<Registration>> poll_registration();

  struct Timeouts {
    std::chrono::milliseconds wait{};     ///< a call waits for its answer at most this long
    std::chrono::milliseconds overdue{};  ///< an answer that takes longer is overdue
  };
  /// `remark`: a text behind the label, which other processes can read. Any thread. Requests take turns.
  /// The error is Errc::unavailable if the daemon has not answered yet, see awaits_answer().
  Result<PortLocation> create_publisher(const iox::capro::ServiceDescription& service,
                                        const iox::popo::PublisherOptions& options, const TakePort& take_port,
                                        const Timeouts& timeouts);
  Result<PortLocation> create_subscriber(const iox::capro::ServiceDescription& service,
                                         const iox::popo::SubscriberOptions& options,
                                         const TakePort& take_port, const Timeouts& timeouts,
                                         const std::string& remark = {});
  /// Returns whether the daemon was asked for a port, and its answer is neither there nor overdue. A call
  /// that has failed may succeed soon then. Any thread.
  bool awaits_answer() const;
  /// Gives ports back that were answered late, and that no call has asked for again. Any thread.
  void give_back_untaken(const TakePort& take_port);

  /// Tells the daemon to remove everything that this process has there. Does not wait.
  void say_goodbye() noexcept;

 private:
  class Turn;
  struct Question {
    std::string port;     ///< distinguishes the port from all others of this process
    std::string label{};  ///< identifies the answer
    iox::runtime::IpcMessageType wanted{};
    Clock::time_point overdue_at{};
  };
  struct Answer {
    Result<PortLocation> location;
    Clock::time_point kept_until{};
  };
  RoudiChannel(std::string runtime_name, Descriptor from_daemon, Descriptor to_daemon);
  Result<void> send(const iox::runtime::IpcMessage& message, Clock::time_point deadline);
  Result<iox::runtime::IpcMessage> receive(Clock::time_point deadline);
  using MakeRequest = std::function<iox::runtime::IpcMessage(const std::string& label)>;
  Result<PortLocation> ask_for_port(Question next, const MakeRequest& make, const TakePort& take_port,
                                    const Timeouts& timeouts);
  Result<void> take_answers(const TakePort& take_port, Clock::time_point deadline);
  void note(const iox::runtime::IpcMessage& message, const TakePort& take_port);
  void late_answer_came();
  void drop_untaken(const TakePort& take_port, Clock::time_point now);
  std::optional<Question> question() const;
  void set_question(std::optional<Question> question);

  std::string runtime_name_;
  Descriptor from_daemon_;  ///< bound to /tmp/<runtime name>, where the daemon answers
  Descriptor to_daemon_;    ///< connected, so that no message can reach a later daemon
  std::int64_t registration_stamp_ = 0;

  mutable core::Mutex turn_mutex_;
  core::Condition turn_ends_;
  bool turn_taken_ SFT_GUARDED_BY(turn_mutex_) = false;           ///< a request is under way
  std::optional<Question> question_ SFT_GUARDED_BY(turn_mutex_);  ///< the question that is not answered yet
  // Only the thread that has the turn uses these.
  std::uint64_t requests_ = 0;
  std::size_t overdue_ = 0;  ///< questions that were given up, and whose answers come before all others
  std::map<std::string, Answer> answers_;  ///< the answers that no call has taken yet, by the port
  /// The number of questions whose port was neither taken nor given back. Any thread reads it.
  std::atomic<std::size_t> unsettled_{0};
};

}  // namespace sft::shm
