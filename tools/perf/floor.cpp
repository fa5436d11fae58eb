#include "tools/perf/floor.h"

#include <fmt/format.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <limits>

#include "tools/perf/usage.h"

namespace sft::perf {

namespace {

constexpr std::size_t datagram_bytes = 60'000;  // IP cuts a datagram into frames
constexpr std::uint64_t message_bytes_max = 128 * 1024 * 1024;
// The time within which a thread notices that it has to end
constexpr auto wake_up_period = std::chrono::milliseconds(200);
// A peer that sends no header within this time is closed
constexpr std::int64_t first_header_ns = 2'000'000'000;
constexpr std::int64_t never_ns = std::numeric_limits<std::int64_t>::max();

/// The header before each message of TCP, and in each datagram of UDP.
struct Header {
  std::uint64_t token = 0;
  std::uint64_t number = 0;
  std::uint64_t bytes = 0;  ///< the size of the whole message, with one header
};

/// A function that is called for each whole message.
using Handle = std::function<void(const Header&, const sockaddr_in& from)>;

void prepare(int socket, Socket kind) {
  const timeval receive_timeout{0, std::chrono::microseconds(wake_up_period).count()};
  const timeval timeout{2, 0};  // the limit if the peer hangs or does not answer
  setsockopt(socket, SOL_SOCKET, SO_RCVTIMEO, &receive_timeout, sizeof receive_timeout);
  setsockopt(socket, SOL_SOCKET, SO_SNDTIMEO, &timeout, sizeof timeout);
  const int buffer = 8 * 1024 * 1024, on = 1;
  if (kind == Socket::tcp) {
    setsockopt(socket, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
  } else {
    setsockopt(socket, SOL_SOCKET, SO_RCVBUF, &buffer, sizeof buffer);
  }
}

/// Sends all bytes. Returns false if that fails. If only a part of the message was sent, ends the stream,
/// because the receiver could not find the beginning of the next message.
bool write_all(int socket, const char* data, std::size_t bytes) {
  for (const std::size_t whole = bytes; bytes > 0;) {
    const ssize_t sent = ::send(socket, data, bytes, MSG_NOSIGNAL);
    if (sent <= 0 && bytes < whole) shutdown(socket, SHUT_WR);
    if (sent <= 0) return false;
    data += sent;
    bytes -= static_cast<std::size_t>(sent);
  }
  return true;
}

bool read_all(int socket, char* data, std::size_t bytes, const std::atomic<bool>& ending,
              std::int64_t until_ns = never_ns) {
  while (bytes > 0 && !ending && now_ns() < until_ns) {
    const ssize_t came = recv(socket, data, bytes, 0);
    if (came == 0 || (came < 0 && errno != EAGAIN && errno != EINTR)) return false;
    if (came < 0) continue;
    data += came;
    bytes -= static_cast<std::size_t>(came);
  }
  return bytes == 0;
}

void put_header(std::vector<char>& message, const Header& header) {
  message.resize(std::max<std::size_t>(header.bytes, sizeof header));
  std::memcpy(message.data(), &header, sizeof header);
}

/// Sends the message in as many datagrams as necessary. Each datagram has the header.
bool send_datagrams(int socket, std::vector<char>& message, const sockaddr_in* to) {
  std::vector<char> datagram(std::min(message.size(), datagram_bytes));
  std::memcpy(datagram.data(), message.data(), sizeof(Header));
  const std::size_t room = datagram_bytes - sizeof(Header);
  for (std::size_t at = sizeof(Header), first = 1; first != 0 || at < message.size(); at += room, first = 0) {
    const std::size_t part = std::min(room, message.size() - at);
    std::memcpy(datagram.data() + sizeof(Header), message.data() + at, part);
    if (sendto(socket, datagram.data(), sizeof(Header) + part, 0, reinterpret_cast<const sockaddr*>(to),
               to == nullptr ? 0 : sizeof *to) < 0)
      return false;
  }
  return true;
}

void receive_datagrams(int socket, std::uint64_t token, const std::atomic<bool>& ending,
                       const Handle& handle) {
  std::vector<char> datagram(datagram_bytes);
  std::uint64_t number = 0, came = 0;  // the message of which parts have arrived, and their bytes
  while (!ending) {
    sockaddr_in from{};
    socklen_t length = sizeof from;
    const ssize_t bytes =
        recvfrom(socket, datagram.data(), datagram.size(), 0, reinterpret_cast<sockaddr*>(&from), &length);
    Header header;
    if (bytes < static_cast<ssize_t>(sizeof header)) continue;
    std::memcpy(&header, datagram.data(), sizeof header);
    if (header.token != token || header.bytes > message_bytes_max) continue;
    if (header.number != number) came = sizeof header;
    number = header.number;
    came += static_cast<std::uint64_t>(bytes) - sizeof header;
    if (came < header.bytes) continue;
    number = 0;  // the next datagram begins a new message, even if it has the same number
    handle(header, from);
  }
}

/// Receives messages until `ending` or the end of the stream. Also ends if the first header has not arrived
/// by `until_ns`.
void receive_stream(int socket, std::uint64_t token, const std::atomic<bool>& ending, std::int64_t until_ns,
                    const Handle& handle) {
  std::vector<char> body;
  Header header;
  while (read_all(socket, reinterpret_cast<char*>(&header), sizeof header, ending, until_ns)) {
    until_ns = never_ns;
    if (header.token != token || header.bytes > message_bytes_max || header.bytes < sizeof header) return;
    body.resize(header.bytes);
    if (!read_all(socket, body.data(), header.bytes - sizeof header, ending)) return;
    handle(header, {});
  }
}

const char* name_of(Socket kind) { return kind == Socket::udp ? "UDP" : "TCP"; }

tl::unexpected<Error> refused(Socket kind, const std::string& what) {
  return fail(Errc::system, fmt::format("{} beside SFT: {}: {}", name_of(kind), what, std::strerror(errno)));
}

int new_socket(Socket kind) {
  return socket(AF_INET, (kind == Socket::udp ? SOCK_DGRAM : SOCK_STREAM) | SOCK_CLOEXEC, 0);
}

}  // namespace

Result<std::unique_ptr<FloorServer>> FloorServer::open(Socket kind, std::uint64_t token, bool answers) {
  const int fd = new_socket(kind);
  sockaddr_in here{};
  here.sin_family = AF_INET;
  const bool bound = fd >= 0 && bind(fd, reinterpret_cast<const sockaddr*>(&here), sizeof here) == 0 &&
                     (kind == Socket::udp || listen(fd, 1) == 0);
  if (bound) return std::unique_ptr<FloorServer>(new FloorServer(kind, fd, token, answers));
  auto error = refused(kind, "no socket could be opened");
  if (fd >= 0) close(fd);
  return error;
}

FloorServer::FloorServer(Socket kind, int listening, std::uint64_t token, bool answers)
    : kind_(kind), socket_(listening), token_(token), answers_(answers) {
  prepare(socket_, kind_);
  sockaddr_in here{};
  socklen_t length = sizeof here;
  getsockname(socket_, reinterpret_cast<sockaddr*>(&here), &length);
  port_ = ntohs(here.sin_port);
  thread_ = std::thread([this] {
    if (kind_ == Socket::tcp) return serve_tcp();
    std::vector<char> message;
    receive_datagrams(socket_, token_, ending_, [&](const Header& header, const sockaddr_in& from) {
      ++received_;
      put_header(message, header);
      if (answers_) send_datagrams(socket_, message, &from);
    });
  });
}

void FloorServer::serve_tcp() {
  while (!ending_) {
    const int peer = accept4(socket_, nullptr, nullptr, SOCK_CLOEXEC);
    if (peer < 0) {  // after a timeout, or at once if the process has no free descriptors
      if (errno != EAGAIN) std::this_thread::sleep_for(wake_up_period);
      continue;
    }
    prepare(peer, Socket::tcp);
    std::vector<char> message;
    receive_stream(peer, token_, ending_, now_ns() + first_header_ns,
                   [&](const Header& header, const sockaddr_in&) {
                     ++received_;
                     put_header(message, header);
                     if (answers_) write_all(peer, message.data(), message.size());
                   });
    close(peer);
  }
}

FloorServer::~FloorServer() {
  ending_ = true;
  thread_.join();
  close(socket_);
}

Result<std::unique_ptr<FloorClient>> FloorClient::open(Socket kind, const std::string& host,
                                                       std::uint16_t port, std::uint64_t token,
                                                       std::size_t bytes, Answer answer) {
  addrinfo hints{};
  hints.ai_family = AF_INET;
  hints.ai_flags = AI_NUMERICHOST;
  addrinfo* found = nullptr;
  if (getaddrinfo(host.c_str(), nullptr, &hints, &found) != 0)
    return fail(Errc::unavailable,
                fmt::format("{} beside SFT: {} is no address of IPv4", name_of(kind), host));
  sockaddr_in there{};
  std::memcpy(&there, found->ai_addr, sizeof there);
  freeaddrinfo(found);
  there.sin_port = htons(port);
  const int fd = new_socket(kind);
  if (fd >= 0) prepare(fd, kind);
  if (fd >= 0 && connect(fd, reinterpret_cast<const sockaddr*>(&there), sizeof there) == 0)
    return std::unique_ptr<FloorClient>(new FloorClient(kind, fd, token, bytes, std::move(answer)));
  auto error =
      refused(kind, fmt::format("port {} of {} does not answer; a firewall may forbid it", port, host));
  if (fd >= 0) close(fd);
  return error;
}

FloorClient::FloorClient(Socket kind, int connected, std::uint64_t token, std::size_t bytes, Answer answer)
    : kind_(kind), socket_(connected), token_(token), message_(bytes), answer_(std::move(answer)) {
  thread_ = std::thread([this] {
    const Handle handle = [this](const Header& header, const sockaddr_in&) { answer_(header.number); };
    kind_ == Socket::udp ? receive_datagrams(socket_, token_, ending_, handle)
                         : receive_stream(socket_, token_, ending_, never_ns, handle);
  });
}

FloorClient::~FloorClient() {
  ending_ = true;
  shutdown(socket_, SHUT_RDWR);
  thread_.join();
  close(socket_);
}

bool FloorClient::send(std::uint64_t number) {
  put_header(message_, {token_, number, std::max(message_.size(), sizeof(Header))});
  return kind_ == Socket::udp ? send_datagrams(socket_, message_, nullptr)
                              : write_all(socket_, message_.data(), message_.size());
}

}  // namespace sft::perf
