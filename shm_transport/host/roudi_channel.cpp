#include "shm_transport/host/roudi_channel.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <tuple>
#include <utility>

#include "core/platform/trusted_file.h"
#include "shm_transport/host/access.h"
#include "shm_transport/host/host_file.h"
#include "shm_transport/host/membership.h"
#include "shm_transport/host/socket_address.h"

namespace sft::shm {

using iox::runtime::IpcMessage;
using iox::runtime::IpcMessageErrorType;
using iox::runtime::IpcMessageType;

namespace {

std::string path_of(const std::string& runtime_name) {
  return iox::platform::IOX_UDS_SOCKET_PATH_PREFIX + runtime_name;
}

/// Allows the daemon to write to the socket of this process, even if the daemon runs as another user. If
/// the file system cannot give rights to a single user, the daemon's group gets them. That works only if
/// this process is in that group.
void let_daemon_answer(const std::string& path, const struct stat& daemon) {
  if (daemon.st_uid == geteuid()) return;
  if (grant_to_user(path, daemon.st_uid)) return;
  if (chown(path.c_str(), geteuid(), daemon.st_gid) == 0) chmod(path.c_str(), 0660);
}

Result<Descriptor> listen_at(const std::string& path, const struct stat& daemon) {
  Descriptor socket(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  const sockaddr_un address = socket_address(path);
  if (!socket || bind(socket.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
    return fail(errno == EACCES ? Errc::no_permission : Errc::system,
                path + ": " + std::strerror(errno) + "; shared memory needs a writable /tmp");
  }
  chmod(path.c_str(), 0600);
  let_daemon_answer(path, daemon);
  return socket;
}

/// Connects to the socket of the daemon. The socket must belong to the account of the daemon. Otherwise
/// another account that has put a socket there would get the messages for the daemon. The path is resolved
/// once, so that the socket that is connected is the socket that was checked.
Result<Descriptor> connect_to(const char* path, uid_t daemon_user, struct stat& daemon) {
  const Descriptor resolved(::open(path, O_PATH | O_NOFOLLOW | O_CLOEXEC));
  const bool there = resolved && fstat(resolved.get(), &daemon) == 0;
  if (there && (!S_ISSOCK(daemon.st_mode) || daemon.st_uid != daemon_user))
    return fail(Errc::address_in_use, std::string(path) + " is not the daemon's socket; it belongs to " +
                                          core::account_name(daemon.st_uid) +
                                          "; remove it, and end the daemon: sftd stop");
  Descriptor socket(there ? ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0) : -1);
  const sockaddr_un address = socket_address("/proc/self/fd/" + std::to_string(resolved.get()));
  if (!socket || connect(socket.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
    if (errno == EACCES) {
      return fail(Errc::no_permission, std::string(path) + ": permission denied; " +
                                           how_to_join(Membership::of_this_process(daemon.st_gid)));
    }
    return fail(Errc::unavailable, std::string(path) + ": " + std::strerror(errno) +
                                       "; does this program have another /tmp than sftd (a container)?");
  }
  return socket;
}

/// Returns whether the descriptor became ready before the deadline.
bool wait_for(int descriptor, short events, Clock::time_point deadline) {
  const auto remaining = std::max(deadline - Clock::now(), Clock::duration::zero());
  const auto ns = std::chrono::duration_cast<std::chrono::nanoseconds>(remaining).count();
  const timespec timeout{static_cast<time_t>(ns / 1'000'000'000), static_cast<long>(ns % 1'000'000'000)};
  pollfd wanted{descriptor, events, 0};
  return ppoll(&wanted, 1, &timeout, nullptr) > 0;
}

std::uint64_t number_at(const IpcMessage& message, std::uint32_t index) {
  const std::string text = message.getElementAtIndex(index);
  std::uint64_t number = 0;
  std::from_chars(text.data(), text.data() + text.size(), number);
  return number;
}

IpcMessageType type_of(const IpcMessage& message) {
  return iox::runtime::stringToIpcMessageType(message.getElementAtIndex(0).c_str());
}

template <class T>
std::string serialized(const T& value) {
  return static_cast<iox::cxx::Serialization>(value).toString();
}

std::string reason_of(IpcMessageErrorType error) {
  switch (error) {
    case IpcMessageErrorType::PUBLISHER_LIST_FULL:
      return "sftd has no room for another writer (it serves " + std::to_string(writers_max) +
             ", or as many as its limits say; see sftd status); close some writers, or use UDP for this "
             "topic";
    case IpcMessageErrorType::SUBSCRIBER_LIST_FULL:
      return "sftd has no room for another reader (it serves " + std::to_string(readers_max) +
             ", or as many as its limits say, and each writer counts as one reader; see sftd status); close "
             "some "
             "readers, or use UDP for this topic";
    case IpcMessageErrorType::REQUEST_PUBLISHER_NO_WRITABLE_SHM_SEGMENT:
      return "this user may not write to sftd's memory; run it as a member of the group that publishes";
    default:
      return "sftd refused the port (iceoryx error " + std::to_string(static_cast<int>(error)) + ")";
  }
}

/// The time for which a late answer is kept for the next request of the same port.
constexpr std::chrono::seconds kept_for{2};

tl::unexpected<Error> not_yet() { return fail(Errc::unavailable, "sftd has not answered yet"); }

tl::unexpected<Error> too_late() {
  return fail(Errc::unavailable, "sftd did not answer in time; is it stopped or is the machine overloaded?");
}

/// The daemon writes the node's name in the request into the port. So the request has its label in place of
/// the node's name.
template <class Options>
IpcMessage request_for_port(IpcMessageType type, const std::string& runtime_name,
                            const iox::capro::ServiceDescription& service, Options options,
                            const std::string& label) {
  options.nodeName = iox::NodeName_t(iox::cxx::TruncateToCapacity, label);
  IpcMessage request;
  request << iox::runtime::IpcMessageTypeToString(type) << runtime_name << serialized(service)
          << options.serialize().toString() << serialized(iox::runtime::PortConfigInfo{});
  return request;
}

}  // namespace

/// The right of a thread to send requests to the daemon (the turn), which only one thread has at a time. A
/// mutex would not do, because threads wait for this right with a deadline and keep it over system calls.
class RoudiChannel::Turn {
 public:
  Turn(RoudiChannel& channel, Clock::time_point deadline) : channel_(channel) {
    core::Lock lock(channel.turn_mutex_);
    while (channel.turn_taken_ && channel.turn_ends_.wait_until(lock, deadline)) continue;
    taken_ = !std::exchange(channel.turn_taken_, true);
  }
  ~Turn() {
    if (!taken_) return;
    {
      const core::Lock lock(channel_.turn_mutex_);
      channel_.turn_taken_ = false;
    }
    channel_.turn_ends_.notify_one();
  }
  explicit operator bool() const { return taken_; }

 private:
  RoudiChannel& channel_;
  bool taken_ = false;
};

RoudiChannel::RoudiChannel(std::string runtime_name, Descriptor from_daemon, Descriptor to_daemon)
    : runtime_name_(std::move(runtime_name)),
      from_daemon_(std::move(from_daemon)),
      to_daemon_(std::move(to_daemon)) {}

RoudiChannel::~RoudiChannel() { unlink(path_of(runtime_name_).c_str()); }

Result<std::unique_ptr<RoudiChannel>> RoudiChannel::open(const std::string& runtime_name, uid_t daemon_user) {
  struct stat daemon {};
  auto to_daemon = connect_to(roudi_socket_path, daemon_user, daemon);
  if (!to_daemon) return tl::unexpected(to_daemon.error());
  auto from_daemon = listen_at(path_of(runtime_name), daemon);
  if (!from_daemon) return tl::unexpected(from_daemon.error());
  std::unique_ptr<RoudiChannel> channel(
      new RoudiChannel(runtime_name, std::move(*from_daemon), std::move(*to_daemon)));

  channel->registration_stamp_ = std::chrono::system_clock::now().time_since_epoch().count();
  IpcMessage request;
  request << iox::runtime::IpcMessageTypeToString(IpcMessageType::REG) << runtime_name
          << std::to_string(getpid()) << std::to_string(geteuid())
          << std::to_string(channel->registration_stamp_)
          << serialized(iox::version::VersionInfo::getCurrentVersion());
  if (auto sent = channel->send(request, Clock::now()); !sent) return tl::unexpected(sent.error());
  return channel;
}

Result<std::optional<Registration>> RoudiChannel::poll_registration() {
  const auto answer = receive(Clock::now());
  if (!answer) return std::optional<Registration>{};
  if (type_of(*answer) == IpcMessageType::ERROR && answer->getElementAtIndex(1) == too_many_processes) {
    return fail(
        Errc::limit_exceeded,
        "sftd already serves as many programs as its configuration allows; see sftd status, and raise "
        "limits.processes in its configuration");
  }
  const bool ours = type_of(*answer) == IpcMessageType::REG_ACK && answer->getNumberOfElements() == 5 &&
                    number_at(*answer, 3) == static_cast<std::uint64_t>(registration_stamp_);
  if (!ours)
    return fail(Errc::malformed, "sftd answered a registration with \"" + answer->getMessage() + "\"");
  return Registration{number_at(*answer, 1), number_at(*answer, 4), number_at(*answer, 2)};
}

Result<void> RoudiChannel::send(const IpcMessage& message, Clock::time_point deadline) {
  const std::string text = message.getMessage();
  for (;;) {
    const ssize_t sent = ::send(to_daemon_.get(), text.c_str(), text.size() + 1, MSG_DONTWAIT | MSG_NOSIGNAL);
    if (sent >= 0) return {};
    if (errno == EINTR) continue;
    if (errno != EAGAIN) return fail(Errc::unavailable, std::string("sftd is gone: ") + std::strerror(errno));
    if (!wait_for(to_daemon_.get(), POLLOUT, deadline)) return too_late();
  }
}

Result<IpcMessage> RoudiChannel::receive(Clock::time_point deadline) {
  for (;;) {
    char text[iox::platform::IOX_UDS_SOCKET_MAX_MESSAGE_SIZE + 1];
    const ssize_t bytes = recv(from_daemon_.get(), text, sizeof text - 1, MSG_DONTWAIT);
    if (bytes >= 0) {
      text[bytes] = '\0';
      return IpcMessage(std::string(text));
    }
    if (errno == EINTR) continue;
    if (errno != EAGAIN)
      return fail(Errc::system,
                  std::string("the socket on which this process hears sftd: ") + std::strerror(errno));
    if (!wait_for(from_daemon_.get(), POLLIN, deadline)) return too_late();
  }
}

Result<PortLocation> RoudiChannel::create_publisher(const iox::capro::ServiceDescription& service,
                                                    const iox::popo::PublisherOptions& options,
                                                    const TakePort& take_port, const Timeouts& timeouts) {
  const auto make = [&](const std::string& label) {
    return request_for_port(IpcMessageType::CREATE_PUBLISHER, runtime_name_, service, options, label);
  };
  return ask_for_port(
      {.port = "publisher " + serialized(service), .wanted = IpcMessageType::CREATE_PUBLISHER_ACK}, make,
      take_port, timeouts);
}

Result<PortLocation> RoudiChannel::create_subscriber(const iox::capro::ServiceDescription& service,
                                                     const iox::popo::SubscriberOptions& options,
                                                     const TakePort& take_port, const Timeouts& timeouts,
                                                     const std::string& remark) {
  const auto make = [&](const std::string& label) {
    return request_for_port(IpcMessageType::CREATE_SUBSCRIBER, runtime_name_, service, options, label);
  };
  const std::string queue =
      options.subscribeOnCreate ? " queue of " + std::to_string(options.queueCapacity) : "";
  return ask_for_port({.port = "subscriber " + serialized(service) + queue,
                       .label = remark,
                       .wanted = IpcMessageType::CREATE_SUBSCRIBER_ACK},
                      make, take_port, timeouts);
}

/// Sends the daemon one request at a time. An error message of the daemon names no port, so this is the
/// only way to know which request it answers. The caller has set `next.label` to a remark. This function
/// puts the number of the request before the remark.
Result<PortLocation> RoudiChannel::ask_for_port(Question next, const MakeRequest& make,
                                                const TakePort& take_port, const Timeouts& timeouts) {
  const auto begun = Clock::now();
  const auto deadline = begun + timeouts.wait;
  const Turn turn(*this, deadline);
  if (!turn) return not_yet();
  if (auto taken = take_answers(take_port, begun); !taken) return tl::unexpected(taken.error());
  drop_untaken(take_port, begun);
  const std::string port = next.port += next.label;
  if (!answers_.contains(port) && !question()) {
    next.label.insert(0, runtime_name_ + "#" + std::to_string(++requests_));
    if (auto sent = send(make(next.label), deadline); !sent) return tl::unexpected(sent.error());
    next.overdue_at = begun + timeouts.overdue;
    set_question(std::move(next));
    ++unsettled_;
    if (auto taken = take_answers(take_port, deadline); !taken) return tl::unexpected(taken.error());
  }
  if (auto answer = answers_.extract(port)) {
    --unsettled_;
    return answer.mapped().location;
  }
  const auto open = question();
  if (!open || Clock::now() < open->overdue_at) return not_yet();
  set_question(std::nullopt);
  ++overdue_;
  return too_late();
}

/// Takes messages until the question is answered, or the deadline is over. Messages that have already
/// arrived are taken in any case.
Result<void> RoudiChannel::take_answers(const TakePort& take_port, Clock::time_point deadline) {
  for (;;) {
    const auto message = receive(question() ? deadline : Clock::time_point{});
    if (message) {
      note(*message, take_port);
    } else if (message.error().code == Errc::unavailable) {
      return {};
    } else {
      return tl::unexpected(message.error());
    }
  }
}

/// The daemon answers in the order of the questions. A port also has the label of its question, but an
/// error has none. While overdue answers are still to come, an error is taken as one of these answers. A
/// port whose answer came too late is given back.
void RoudiChannel::note(const IpcMessage& message, const TakePort& take_port) {
  const std::optional<Question> asked = question();
  const auto answer = [&](Result<PortLocation> location) {
    answers_.insert_or_assign(asked->port, Answer{std::move(location), Clock::now() + kept_for});
    set_question(std::nullopt);
  };
  if (type_of(message) == IpcMessageType::ERROR) {
    const auto error = iox::runtime::stringToIpcMessageErrorType(message.getElementAtIndex(1).c_str());
    asked&& overdue_ == 0 ? answer(fail(Errc::limit_exceeded, reason_of(error))) : late_answer_came();
    return;
  }
  if (message.getNumberOfElements() != 3) return;
  const PortLocation location{number_at(message, 2), number_at(message, 1)};
  const bool is_ours = take_port(location, asked ? asked->label : "") && asked;
  if (!is_ours || type_of(message) != asked->wanted) return late_answer_came();
  overdue_ = 0;
  answer(location);
}

void RoudiChannel::late_answer_came() {
  if (overdue_ > 0) --overdue_;
  if (unsettled_ > 0) --unsettled_;
}

void RoudiChannel::drop_untaken(const TakePort& take_port, Clock::time_point now) {
  std::erase_if(answers_, [&](const auto& item) {
    const Answer& answer = item.second;
    if (now < answer.kept_until) return false;
    if (answer.location) take_port(*answer.location, "");
    --unsettled_;
    return true;
  });
}

void RoudiChannel::give_back_untaken(const TakePort& take_port) {
  if (unsettled_ == 0) return;
  const auto now = Clock::now();
  const Turn turn(*this, now);
  if (turn && take_answers(take_port, now)) drop_untaken(take_port, now);
}

bool RoudiChannel::awaits_answer() const {
  const core::Lock lock(turn_mutex_);
  return turn_taken_ || (question_ && Clock::now() < question_->overdue_at);
}

std::optional<RoudiChannel::Question> RoudiChannel::question() const {
  const core::Lock lock(turn_mutex_);
  return question_;
}

void RoudiChannel::set_question(std::optional<Question> question) {
  const core::Lock lock(turn_mutex_);
  question_ = std::move(question);
}

void RoudiChannel::say_goodbye() noexcept {
  IpcMessage message;
  message << iox::runtime::IpcMessageTypeToString(IpcMessageType::TERMINATION) << runtime_name_;
  std::ignore = send(message, Clock::now());
}

}  // namespace sft::shm
