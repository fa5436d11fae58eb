// The reference over UDP: two processes with blocking sockets.
#include <arpa/inet.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <vector>

#include "bench/common/hosts.h"
#include "bench/spine/spine.h"

namespace sft::bench {

namespace {

constexpr std::uint16_t port = 45'900;

int bound_socket() {
  const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  sockaddr_in here{};
  here.sin_family = AF_INET;
  here.sin_port = htons(port);
  const timeval second{1, 0};  // so that a lost datagram does not end everything
  setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &second, sizeof second);
  if (bind(fd, reinterpret_cast<sockaddr*>(&here), sizeof here) != 0) _exit(1);
  return fd;
}

void ping(Exchange& exchange, std::uint64_t messages, std::size_t bytes) {
  const int fd = bound_socket();
  sockaddr_in peer{};
  peer.sin_family = AF_INET;
  peer.sin_port = htons(port);
  peer.sin_addr.s_addr = TwoHosts::receiver_address();
  std::vector<std::uint8_t> message(bytes);
  while (!exchange.ready.load()) pause_us(100);
  for (std::uint64_t i = 0; i < messages; ++i) {
    const std::int64_t sent_at = now_ns();
    sendto(fd, message.data(), bytes, 0, reinterpret_cast<sockaddr*>(&peer), sizeof peer);
    if (recv(fd, message.data(), bytes, 0) > 0) exchange.received_at[i] = (now_ns() - sent_at) / 2;
  }
  exchange.received = messages;
  close(fd);
}

void echo(Exchange& exchange, std::uint64_t messages, std::size_t bytes) {
  const int fd = bound_socket();
  std::vector<std::uint8_t> message(bytes);
  exchange.ready = true;
  while (exchange.received.load() < messages) {
    sockaddr_in peer{};
    socklen_t length = sizeof peer;
    if (recvfrom(fd, message.data(), bytes, 0, reinterpret_cast<sockaddr*>(&peer), &length) > 0) {
      sendto(fd, message.data(), bytes, 0, reinterpret_cast<sockaddr*>(&peer), length);
    }
  }
  close(fd);
}

}  // namespace

std::vector<double> raw_socket_ping_pong(std::uint64_t messages, std::size_t bytes, const Sides& hosts) {
  Sides sides = hosts;
  sides.sender = [=](Exchange& e) { ping(e, messages, bytes); };
  sides.receiver = [=](Exchange& e) { echo(e, messages, bytes); };
  return run_pair(sides, messages);
}

}  // namespace sft::bench
