#include "tools/demo/roles/channel.h"

#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <string>

namespace sft::demo {

namespace {

constexpr std::size_t message_bytes_max = 64 * 1024;

/// Returns the time that is left until the deadline, as ppoll() takes it; zero if the deadline has passed.
timespec time_until(Clock::time_point deadline) {
  const auto left = std::max(deadline - Clock::now(), Clock::duration::zero());
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(left);
  return {.tv_sec = seconds.count(), .tv_nsec = std::chrono::nanoseconds(left - seconds).count()};
}

}  // namespace

Result<std::pair<Channel, Channel>> Channel::make_pair() {
  int ends[2];
  if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends) != 0) {
    return fail(Errc::system, std::string("socketpair: ") + std::strerror(errno));
  }
  return std::pair(Channel(core::FileDescriptor(ends[0])), Channel(core::FileDescriptor(ends[1])));
}

bool Channel::send(const nlohmann::json& message) {
  const std::string text = message.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  return ::send(socket_.get(), text.data(), text.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(text.size());
}

Channel::Received Channel::receive(std::optional<Clock::time_point> deadline) {
  for (;;) {
    pollfd readable{.fd = socket_.get(), .events = POLLIN, .revents = 0};
    const timespec left = deadline ? time_until(*deadline) : timespec{};
    const int ready = ppoll(&readable, 1, deadline ? &left : nullptr, nullptr);
    if (ready < 0 && errno == EINTR) continue;
    if (ready == 0) return {Event::timeout, {}};

    std::string text(message_bytes_max, '\0');
    const ssize_t bytes = recv(socket_.get(), text.data(), text.size(), 0);
    if (bytes < 0 && errno == EINTR) continue;
    if (bytes <= 0) return {Event::closed, {}};
    return {Event::message, nlohmann::json::parse(text.data(), text.data() + bytes)};
  }
}

}  // namespace sft::demo
