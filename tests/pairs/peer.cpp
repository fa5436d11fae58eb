#include "tests/pairs/peer.h"

#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <stdexcept>
#include <system_error>
#include <utility>
#include <vector>

#include "tests/support/eventually.h"

namespace sft::test {

namespace {
constexpr int timeout_ms = static_cast<int>(std::chrono::milliseconds(hang_timeout).count());
constexpr std::size_t answer_bytes_max = 256 * 1024;
}  // namespace

Peer::Peer(const Host& host, std::string name, json options, const Account& account)
    : name_(std::move(name)) {
  int ends[2];
  if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends) != 0)
    throw std::system_error(errno, std::generic_category(), "socketpair");
  socket_ = ends[0];
  options["name"] = name_;
  process_ =
      std::make_unique<Process>(host, "negotiation_peer", std::vector{options.dump()}, ends[1], account);
  close(ends[1]);
}

Peer::~Peer() {
  process_.reset();
  if (socket_ >= 0) close(socket_);
}

void Peer::advertise(json options) {
  options["do"] = "publisher";
  ask(options);
}

void Peer::subscribe(const std::string& fields, json options) {
  options["do"] = "subscriber";
  options["fields"] = fields;
  ask(options);
}

void Peer::publish(std::uint64_t count, std::chrono::microseconds period) {
  ask({{"do", "publish"}, {"count", count}, {"period_us", period.count()}});
}

void Peer::start_publishing(std::chrono::microseconds period) {
  ask({{"do", "start"}, {"period_us", period.count()}});
}

int Peer::quit() {
  close(std::exchange(socket_, -1));
  return process_->wait_for_end();
}

json Peer::ask(const json& command) {
  const std::string text = command.dump();
  pollfd readable{.fd = socket_, .events = POLLIN, .revents = 0};
  std::vector<char> answer(answer_bytes_max);
  if (send(socket_, text.data(), text.size(), MSG_NOSIGNAL) < 0 || poll(&readable, 1, timeout_ms) <= 0)
    throw std::runtime_error("peer " + name_ + " does not answer " + text);
  const ssize_t bytes = recv(socket_, answer.data(), answer.size(), 0);
  if (bytes <= 0) throw std::runtime_error("peer " + name_ + " died of " + text);
  return json::parse(answer.begin(), answer.begin() + bytes);
}

}  // namespace sft::test
