#include "udp_transport/io/udp_socket.h"

#include <netinet/udp.h>
#include <sys/eventfd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <string>
#include <system_error>
#include <thread>
#include <utility>

#include "udp_transport/io/socket_settings.h"

namespace sft::udp {

namespace {

using Clock = std::chrono::steady_clock;
using core::IpAddress;

// The kernel frees the sockets of a killed process, or of a closed io_uring, with a delay. On a busy
// machine, the delay was more than 200 ms.
constexpr std::chrono::milliseconds bind_timeout{1000};
constexpr std::chrono::milliseconds bind_interval{10};

std::string message_of(int error) { return std::system_category().message(error); }

int bind_with_retries(int fd, const SocketAddress& address, int family) {
  const SystemAddress at(address, family);
  const Clock::time_point deadline = Clock::now() + bind_timeout;
  while (::bind(fd, at.get(), at.bytes()) != 0) {
    if (errno != EADDRINUSE || address.port == 0 || Clock::now() > deadline) return errno;
    std::this_thread::sleep_for(bind_interval);
  }
  return 0;
}

tl::unexpected<Error> bind_error(int error, const SocketAddress& address) {
  const std::string port = std::to_string(address.port);
  switch (error) {
    case EADDRINUSE:
      return fail(Errc::address_in_use,
                  "UDP port " + port +
                      " is in use; choose another, or 0 for any free one ('ss -ulpn sport = :" + port +
                      "' names who has it)");
    case EACCES:
      return fail(Errc::no_permission,
                  "UDP port " + port + " needs privileges; choose one above 1023, or 0 for any");
    case EADDRNOTAVAIL:
      return fail(Errc::invalid_argument, "this host has no address " + core::format(address.ip) +
                                              "; 'ip address' lists those it has");
    default:
      return fail(Errc::system, "cannot bind a UDP socket to " + core::format(address.ip, address.port) +
                                    ": " + message_of(error));
  }
}

int get_int(int fd, int level, int name) {
  int value = 0;
  socklen_t size = sizeof value;
  return ::getsockopt(fd, level, name, &value, &size) == 0 ? value : 0;
}

/// Makes the kernel refuse datagrams that are too long for a path instead of fragmenting them. Otherwise one
/// lost fragment would lose the whole datagram. A socket of both families needs the options of IPv4 and of
/// IPv6.
void refuse_fragments(int fd, int family) {
  set_int(fd, IPPROTO_IP, IP_MTU_DISCOVER, IP_PMTUDISC_DO);
  if (family != AF_INET6) return;
  set_int(fd, IPPROTO_IPV6, IPV6_MTU_DISCOVER, IPV6_PMTUDISC_DO);
  set_int(fd, IPPROTO_IPV6, IPV6_DONTFRAG, 1);
}

std::uint16_t bound_port(int fd) {
  sockaddr_in6 address{};
  socklen_t size = sizeof address;
  ::getsockname(fd, reinterpret_cast<sockaddr*>(&address), &size);
  return to_address(address).port;
}

struct OpenSocket {
  FileDescriptor fd;
  int family = AF_INET;
};

/// Opens a socket for both families, or for IPv4 alone if the address is IPv4 or if the system was started
/// without IPv6 (ipv6.disable=1).
OpenSocket open_socket_for(const IpAddress& address) {
  if (!address.is_ipv4()) {
    FileDescriptor both(::socket(AF_INET6, SOCK_DGRAM | SOCK_CLOEXEC, 0));
    // The socket takes both families, whatever net.ipv6.bindv6only says.
    if (both && set_int(both.get(), IPPROTO_IPV6, IPV6_V6ONLY, address.is_any() ? 0 : 1))
      return {std::move(both), AF_INET6};
    if (!address.is_any()) return {{}, AF_INET6};
  }
  return {FileDescriptor(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)), AF_INET};
}

std::size_t segment_bytes(std::span<std::byte> control) noexcept {
  msghdr message{};
  message.msg_control = control.data();
  message.msg_controllen = control.size();
  for (cmsghdr* c = CMSG_FIRSTHDR(&message); c != nullptr; c = CMSG_NXTHDR(&message, c)) {
    if (c->cmsg_level != SOL_UDP || c->cmsg_type != UDP_GRO) continue;
    int bytes = 0;
    std::memcpy(&bytes, CMSG_DATA(c), sizeof bytes);
    return bytes > 0 ? static_cast<std::size_t>(bytes) : 0;
  }
  return 0;
}

constexpr std::size_t messages_per_call = 8;
// The values of TC_PRIO_INTERACTIVE and TC_PRIO_BULK.
constexpr int priority_interactive = 6, priority_bulk = 2;

/// The argument of sendmsg() for one batch. The object has pointers into itself.
class OutgoingMessage {
 public:
  const msghdr& set(const OutgoingBatch& batch, const SystemAddress* to) noexcept {
    header_ = {};
    if (to != nullptr) {
      // The cast is safe, because the kernel only reads the address.
      header_.msg_name = const_cast<sockaddr*>(to->get());
      header_.msg_namelen = to->bytes();
    }
    header_.msg_iov = const_cast<iovec*>(batch.parts.data());
    header_.msg_iovlen = batch.parts.size();
    if (batch.segment_bytes == 0) return header_;
    header_.msg_control = control_;
    header_.msg_controllen = sizeof control_;
    cmsghdr* c = CMSG_FIRSTHDR(&header_);
    c->cmsg_level = SOL_UDP;
    c->cmsg_type = UDP_SEGMENT;
    c->cmsg_len = CMSG_LEN(sizeof batch.segment_bytes);
    std::memcpy(CMSG_DATA(c), &batch.segment_bytes, sizeof batch.segment_bytes);
    return header_;
  }

 private:
  msghdr header_;
  alignas(cmsghdr) std::byte control_[CMSG_SPACE(sizeof(std::uint16_t))];
};

ArrivalTime arrival_time() noexcept {
  const auto realtime = std::chrono::system_clock::now().time_since_epoch();
  return {Clock::now(), std::chrono::duration_cast<std::chrono::nanoseconds>(realtime).count()};
}

}  // namespace

Result<std::shared_ptr<const UdpSocket>> open_udp_socket(const SocketOptions& options) {
  auto socket = std::make_shared<UdpSocket>();
  OpenSocket open = open_socket_for(options.bind.ip);
  if (!open.fd) return fail(Errc::system, "cannot open a UDP socket: " + message_of(errno));
  socket->fd = std::move(open.fd);
  socket->family = open.family;
  const int fd = socket->fd.get();
  if (const int error = bind_with_retries(fd, options.bind, open.family); error != 0) {
    return bind_error(error, options.bind);
  }
  set_receive_buffer(fd, options.receive_buffer_bytes);
  set_send_buffer(fd, options.send_buffer_bytes);
  refuse_fragments(fd, open.family);
  // Answers are sent by this socket. They are short, but a path may carry even less.
  set_int(fd, IPPROTO_IP, IP_MTU_DISCOVER, IP_PMTUDISC_WANT);
  socket->options = options;
  socket->receives_trains = set_int(fd, SOL_UDP, UDP_GRO, 1);
  if (!socket->receives_trains) socket->why_no_gro = "the system refuses it: " + message_of(errno);
  int segment = 0;
  socklen_t room = sizeof segment;
  if (::getsockopt(fd, SOL_UDP, UDP_SEGMENT, &segment, &room) != 0)
    socket->why_no_gso = "the system refuses it: " + message_of(errno);
  socket->receive_buffer_bytes = static_cast<std::uint32_t>(get_int(fd, SOL_SOCKET, SO_RCVBUF));
  socket->port = bound_port(fd);
  if (options.hears_groups) socket->groups = open_group_socket(fd, options.receive_buffer_bytes);
  return socket;
}

FileDescriptor open_sending_socket(const SocketOptions& options, int family) noexcept {
  FileDescriptor socket(::socket(family, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  if (!socket) return socket;
  const int fd = socket.get();
  const SystemAddress from({options.bind.ip, 0}, family);
  if (!options.bind.ip.is_any() && from.family() == family) ::bind(fd, from.get(), from.bytes());
  set_send_buffer(fd, options.send_buffer_bytes);
  set_int(fd, SOL_SOCKET, SO_PRIORITY, priority_interactive);
  set_int(fd, SOL_SOCKET, SO_RCVBUF, 0);  // no thread reads datagrams that come to this socket
  refuse_fragments(fd, family);
  return socket;
}

void fit_to_path(int fd) noexcept {
  constexpr auto shortest =
      static_cast<int>(datagram_bytes_min + headers_before_datagram(core::loopback_ipv4));
  const int mtu = get_int(fd, IPPROTO_IP, IP_MTU);  // 0 if the socket is not connected, or not by IPv4
  set_int(fd, IPPROTO_IP, IP_MTU_DISCOVER, mtu != 0 && mtu < shortest ? IP_PMTUDISC_DONT : IP_PMTUDISC_DO);
}

void give_way(int fd) noexcept { set_int(fd, SOL_SOCKET, SO_PRIORITY, priority_bulk); }

/// Returns true if the batches are a single buffer for a connected socket. For this case, send() takes less
/// time than sendmsg() with a msghdr.
static bool is_single(std::span<const OutgoingBatch> batches, const SystemAddress* to) noexcept {
  return to == nullptr && batches.size() == 1 && batches[0].segment_bytes == 0 &&
         batches[0].parts.size() == 1;
}

Connection::Sent send_at_once(int fd, std::span<const OutgoingBatch> batches,
                              const SystemAddress* to) noexcept {
  Connection::Sent sent{};
  const auto is_refusal = [](int error) { return error == ECONNREFUSED || error == EHOSTUNREACH; };
  if (is_single(batches, to)) {
    const iovec& all = batches[0].parts[0];
    if (::send(fd, all.iov_base, all.iov_len, MSG_DONTWAIT) >= 0) return {1};
    sent.refused = is_refusal(errno);
  }
  std::array<OutgoingMessage, messages_per_call> messages;
  std::array<mmsghdr, messages_per_call> headers;
  bool again = false;
  while (sent.batches < batches.size()) {
    const auto left =
        batches.subspan(sent.batches, std::min(batches.size() - sent.batches, messages_per_call));
    for (std::size_t i = 0; i < left.size(); ++i) headers[i].msg_hdr = messages[i].set(left[i], to);
    const int n = ::sendmmsg(fd, headers.data(), static_cast<unsigned>(left.size()), MSG_DONTWAIT);
    if (n > 0) sent.batches += static_cast<std::size_t>(n);
    if (n > 0 || errno == EINTR) continue;
    // If there was an ICMP error for an earlier datagram, the call on a connected socket fails once with
    // that error, without sending anything. So it is tried again.
    sent.refused = sent.refused || is_refusal(errno);
    sent.outcome = outcome_of(errno, left[0].segment_bytes != 0);
    if (errno == EAGAIN || std::exchange(again, true)) return sent;
  }
  sent.outcome = SendOutcome::sent;
  return sent;
}

SendOutcome outcome_of(int error, bool segmented) noexcept {
  switch (error) {
    case 0:
      return SendOutcome::sent;
    case EAGAIN:
      return SendOutcome::would_wait;
    case EMSGSIZE:
      return SendOutcome::too_long;
    case EINVAL:  // kernels before 6.13 return this if segments are longer than the path takes
      return segmented ? SendOutcome::too_long : SendOutcome::failed;
    case EIO:
      return SendOutcome::no_segments;  // the device has no checksum offload, or is a tunnel
    default:
      return SendOutcome::failed;
  }
}

Result<FileDescriptor> open_wake_event() {
  FileDescriptor event(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK));
  if (!event)
    return fail(Errc::system, "cannot create an eventfd; raise the limit on open files (ulimit -n)");
  return event;
}

timespec time_until(Clock::time_point deadline) noexcept {
  using namespace std::chrono;
  const auto left = std::max(duration_cast<nanoseconds>(deadline - Clock::now()), nanoseconds{0});
  return {.tv_sec = static_cast<time_t>(left.count() / 1'000'000'000),
          .tv_nsec = static_cast<long>(left.count() % 1'000'000'000)};
}

bool poll_until(std::span<pollfd> polled, Clock::time_point deadline) noexcept {
  const bool limited = deadline != Clock::time_point::max();
  const timespec timeout = limited ? time_until(deadline) : timespec{};
  const int ready = ::ppoll(polled.data(), polled.size(), limited ? &timeout : nullptr, nullptr);
  if (ready < 0) std::ranges::for_each(polled, [](pollfd& p) { p.revents = 0; });
  return ready > 0;
}

void hand_over(std::span<const std::byte> train, std::span<std::byte> control, const sockaddr_in6& from,
               DatagramSink& sink) noexcept {
  const SocketAddress source = to_address(from);
  std::size_t segment = segment_bytes(control);
  if (segment == 0) segment = train.size();
  sink.begin(arrival_time());
  while (!train.empty()) {
    const std::size_t bytes = std::min(segment, train.size());
    // The train, which the kernel has copied, may not be in the nearest cache any more, so its datagrams are
    // prefetched.
    if (train.size() > 2 * segment) __builtin_prefetch(&train[2 * segment]);
    sink.datagram(train.first(bytes), source);
    train = train.subspan(bytes);
  }
  sink.end();
}

}  // namespace sft::udp
