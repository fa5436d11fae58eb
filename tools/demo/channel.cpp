#include "tools/demo/channel.h"

#include <fmt/format.h>
#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <string>

#include "tools/hosts/system_error.h"

namespace sft::demo {

namespace {

constexpr std::size_t message_bytes_max = 64 * 1024;

}  // namespace

Result<std::pair<Channel, Channel>> Channel::make_pair() {
  int ends[2];
  if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends) != 0)
    return hosts::system_error("socketpair");
  return std::pair(Channel(core::FileDescriptor(ends[0])), Channel(core::FileDescriptor(ends[1])));
}

bool Channel::send(const nlohmann::json& message) {
  const std::string text = message.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  return ::send(socket_.get(), text.data(), text.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(text.size());
}

bool Channel::readable_before(Clock::time_point deadline) {
  for (;;) {
    const auto left = std::max(deadline - Clock::now(), Clock::duration::zero());
    const auto seconds = std::chrono::floor<std::chrono::seconds>(left);
    const timespec time{.tv_sec = seconds.count(),
                        .tv_nsec = std::chrono::nanoseconds(left - seconds).count()};
    pollfd readable{.fd = socket_.get(), .events = POLLIN, .revents = 0};
    const int ready = ppoll(&readable, 1, &time, nullptr);
    if (ready >= 0 || errno != EINTR) return ready != 0;
  }
}

std::optional<nlohmann::json> Channel::receive() {
  std::string text(message_bytes_max, '\0');
  ssize_t bytes = 0;
  do {
    bytes = recv(socket_.get(), text.data(), text.size(), 0);
  } while (bytes < 0 && errno == EINTR);
  if (bytes <= 0) return std::nullopt;
  return nlohmann::json::parse(text.data(), text.data() + bytes);
}

Result<nlohmann::json> ask(Channel& channel, std::string_view role, std::string_view order,
                           Clock::duration timeout, tool::Stop* stop) {
  const auto deadline = Clock::now() + timeout;
  channel.send(order);
  if (stop != nullptr && stop->wait_for(timeout, channel.descriptor()))
    return fail(Errc::unavailable, stopped_early);
  if (!channel.readable_before(deadline))
    return fail(Errc::unavailable, fmt::format("the process of the {} does not answer", role));
  std::optional<nlohmann::json> answer = channel.receive();
  if (!answer)
    return fail(Errc::unavailable, fmt::format("the process of the {} has ended unexpectedly", role));
  if (const auto error = answer->find("error"); error != answer->end())
    return fail(Errc::system, fmt::format("{}: {}", role, error->get<std::string>()));
  return std::move(*answer);
}

void refuse(Channel& channel, const Error& error) {
  if (channel.receive()) channel.send({{"error", error.message}});
}

}  // namespace sft::demo
