// Requests ports from the daemon, with the messages of iceoryx's own protocol.
//
// The client of iceoryx (PoshRuntimeImpl) waits for answers without a limit, and aborts the process if
// there is an error. This class sends the same messages, but each call waits only for a short time. An
// answer that comes later is kept for the next call that requests the same port. If the answer is overdue,
// or if no call requests the port again, the port is given back to the daemon.
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

/// The daemon's answer to a process that has registered: the location of the segment that manages all other
/// segments.
struct Registration {
  std::uint64_t management_bytes = 0;
  std::uint64_t management_id = 0;  ///< the segment's number in iceoryx's relative pointers
  std::uint64_t segment_manager_offset = 0;
};

/// The location of a port in shared memory, from the daemon's answer. The caller must check the bounds.
struct PortLocation {
  std::uint64_t segment_id = 0;
  std::uint64_t offset = 0;
};

class RoudiChannel {
 public:
  /// Returns whether the port at this location was requested with this label (in m_nodeName). If the port
  /// was not, the function gives it back. So an answer that missed its deadline is not taken for the answer
  /// to a later request.
  using TakePort = std::function<bool(const PortLocation& location, const std::string& label)>;

  /// Sends the daemon a request to register this process under `runtime_name`, and does not wait for the
  /// answer. `daemon_user` is the account of the daemon.
  static Result<std::unique_ptr<RoudiChannel>> open(const std::string& runtime_name, uid_t daemon_user);
  ~RoudiChannel();

  /// Returns the answer to the registration; nothing if the answer has not arrived yet.
  Result<std::optional<Registration>> poll_registration();

  struct Timeouts {
    std::chrono::milliseconds wait{};     ///< the longest time for which a call waits for its answer
    std::chrono::milliseconds overdue{};  ///< an answer that takes longer is overdue
  };
  /// Requests a port. `remark` is a text that follows the label, which other processes can read. Any thread
  /// may call this; one request is under way at a time. The error is Errc::unavailable if the daemon has
  /// not answered yet; see awaits_answer().
  Result<PortLocation> create_publisher(const iox::capro::ServiceDescription& service,
                                        const iox::popo::PublisherOptions& options, const TakePort& take_port,
                                        const Timeouts& timeouts);
  Result<PortLocation> create_subscriber(const iox::capro::ServiceDescription& service,
                                         const iox::popo::SubscriberOptions& options,
                                         const TakePort& take_port, const Timeouts& timeouts,
                                         const std::string& remark = {});
  /// Returns whether the daemon was asked for a port whose answer has not come and is not overdue yet. In
  /// that case a failed call may succeed if it is repeated soon. Any thread may call this.
  bool awaits_answer() const;
  /// Gives back to the daemon the ports whose answers arrived late, and that no call has requested again.
  /// Any thread may call this.
  void give_back_untaken(const TakePort& take_port);

  /// Sends the daemon a request to remove everything that belongs to this process. Does not wait.
  void say_goodbye() noexcept;

 private:
  class Turn;
  struct Question {
    std::string port;     ///< distinguishes the port from all other ports of this process
    std::string label{};  ///< identifies the answer to this question
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
  Descriptor from_daemon_;  ///< socket at /tmp/<runtime name>, to which the daemon sends its answers
  Descriptor to_daemon_;    ///< a connected socket, so that no message can reach a later daemon
  std::int64_t registration_stamp_ = 0;

  mutable core::Mutex turn_mutex_;
  core::Condition turn_ends_;
  bool turn_taken_ SFT_GUARDED_BY(turn_mutex_) = false;           ///< true while a request is under way
  std::optional<Question> question_ SFT_GUARDED_BY(turn_mutex_);  ///< the question that is not answered yet
  // Only the thread that has the turn (class Turn) uses the following members.
  std::uint64_t requests_ = 0;
  std::size_t overdue_ = 0;  ///< number of questions that were given up; their answers come before all others
  std::map<std::string, Answer> answers_;  ///< by port: the answers that no call has taken yet
  /// The number of questions whose port was neither taken nor given back. Any thread may read it.
  std::atomic<std::size_t> unsettled_{0};
};

}  // namespace sft::shm
