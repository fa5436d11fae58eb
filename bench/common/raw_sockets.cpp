#include "bench/common/raw_sockets.h"

#include <arpa/inet.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <vector>

#include "bench/common/hosts.h"

namespace sft::bench {

namespace {

constexpr std::uint16_t port = 45'900;

int bound_socket() {
  const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  sockaddr_in here{};
  here.sin_family = AF_INET;
  here.sin_port = htons(port);
  const timeval second{1, 0};  // a datagram counts as lost after this time
  setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &second, sizeof second);
  if (bind(fd, reinterpret_cast<sockaddr*>(&here), sizeof here) != 0) _exit(1);
  return fd;
}

/// Receives a datagram and returns its size. Returns 0 or less after a second without a datagram.
ssize_t receive(int fd, std::vector<std::uint8_t>& message, Reading reading, sockaddr_in* from = nullptr) {
  const std::int64_t deadline = now_ns() + 1'000'000'000;
  for (;;) {
    socklen_t length = sizeof *from;
    const ssize_t bytes =
        recvfrom(fd, message.data(), message.size(), reading == Reading::spinning ? MSG_DONTWAIT : 0,
                 reinterpret_cast<sockaddr*>(from), from == nullptr ? nullptr : &length);
    if (bytes > 0 || reading == Reading::sleeping || now_ns() > deadline) return bytes;
  }
}

void ping(Exchange& exchange, std::uint64_t messages, std::size_t bytes, Reading reading,
          std::int64_t pause_us) {
  const int fd = bound_socket();
  sockaddr_in peer{};
  peer.sin_family = AF_INET;
  peer.sin_port = htons(port);
  peer.sin_addr.s_addr = address_of(1);
  std::vector<std::uint8_t> message(bytes);
  while (!exchange.ready.load()) sleep_us(100);
  for (std::uint64_t i = 0; i < messages; ++i) {
    if (pause_us > 0) sleep_us(pause_us);
    const std::int64_t sent_at = now_ns();
    sendto(fd, message.data(), bytes, 0, reinterpret_cast<sockaddr*>(&peer), sizeof peer);
    if (receive(fd, message, reading) > 0) exchange.received_at[i] = (now_ns() - sent_at) / 2;
  }
  exchange.received = messages;
  close(fd);
}

void echo(Exchange& exchange, std::uint64_t messages, std::size_t bytes, Reading reading) {
  const int fd = bound_socket();
  std::vector<std::uint8_t> message(bytes);
  exchange.ready = true;
  while (exchange.received.load() < messages) {
    sockaddr_in peer{};
    if (receive(fd, message, reading, &peer) > 0) {
      sendto(fd, message.data(), bytes, 0, reinterpret_cast<sockaddr*>(&peer), sizeof peer);
    }
  }
  close(fd);
}

}  // namespace

std::vector<double> raw_socket_ping_pong(std::uint64_t messages, std::size_t bytes, Reading reading,
                                         const TwoHosts& hosts, std::int64_t pause_us) {
  return run_pair(hosts.sides([=](Exchange& e) { ping(e, messages, bytes, reading, pause_us); },
                              [=](Exchange& e) { echo(e, messages, bytes, reading); }),
                  messages);
}

}  // namespace sft::bench
