// A process receives by two sockets: its own socket, and the socket for multicast groups. Neither socket may
// starve the other.
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/epoll.h>
#include <sys/socket.h>

#include <chrono>
#include <cstddef>
#include <memory>
#include <span>

#include "tests/support/eventually.h"
#include "tests/transports/udp/backends.h"
#include "udp_transport/io/socket_io.h"
#include "udp_transport/io/uring_io.h"

namespace sft::udp {
namespace {

using Clock = std::chrono::steady_clock;

sockaddr_in address_of(int fd) {
  sockaddr_in address{};
  socklen_t bytes = sizeof address;
  EXPECT_EQ(::getsockname(fd, reinterpret_cast<sockaddr*>(&address), &bytes), 0);
  return address;
}

FileDescriptor open_on_loopback() {
  FileDescriptor socket(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  sockaddr_in any{};
  any.sin_family = AF_INET;
  any.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  EXPECT_EQ(::bind(socket.get(), reinterpret_cast<const sockaddr*>(&any), sizeof any), 0);
  return socket;
}

/// Opens two sockets of this host. One of them stands for the socket for groups.
std::shared_ptr<const UdpSocket> open_both() {
  auto both = std::make_shared<UdpSocket>();
  both->fd = open_on_loopback();
  both->groups.group_fd = open_on_loopback();
  both->groups.either_fd = FileDescriptor(::epoll_create1(EPOLL_CLOEXEC));
  for (const int fd : {both->fd.get(), both->groups.group_fd.get()}) {
    epoll_event readable{.events = EPOLLIN, .data = {.fd = fd}};
    EXPECT_EQ(::epoll_ctl(both->groups.either_fd.get(), EPOLL_CTL_ADD, fd, &readable), 0);
  }
  both->in_groups = true;
  return both;
}

class SocketTurnsTest : public testing::TestWithParam<Backend>, private DatagramSink {
 protected:
  static constexpr std::size_t flood_bytes = 100, stop_bytes = 10;
  /// The number of datagrams that always wait: for each one that is received another one is sent.
  static constexpr int flood_max = 40;

  void SetUp() override {
    if (const std::string refusal = test::refusal_of(GetParam()); !refusal.empty()) GTEST_SKIP() << refusal;
    auto io = GetParam() == Backend::io_uring ? open_uring_io(sockets_) : open_socket_io(sockets_);
    ASSERT_TRUE(io) << io.error().message;
    receiver_ = std::move(io->receiver);
  }
  void TearDown() override {
    if (receiver_ != nullptr) receiver_->finish();
  }
  /// Floods that socket from now on: sends a datagram for each one that is received.
  void flood(const FileDescriptor& to) {
    flooded_ = to.get();
    for (int i = 0; i < flood_max; ++i) send(flooded_, flood_bytes);
  }
  void stop(const FileDescriptor& to) { send(to.get(), stop_bytes); }
  /// Returns true if the stop arrives before very many other datagrams.
  template <class Receive>
  bool stop_comes(Receive receive) {
    while (!stopped_ && others_ < 1000) receive();
    return stopped_;
  }
  bool stop_comes_to_own_thread() {
    return stop_comes([&] { receiver_->receive(*this, Clock::now() + sft::test::hang_timeout, {}); });
  }
  bool stop_comes_to_waiting_thread() {
    return stop_comes([&] { receiver_->receive_now(*this); });
  }

  const std::shared_ptr<const UdpSocket> sockets_ = open_both();

 private:
  void send(int to, std::size_t bytes) const {
    const std::byte datagram[flood_bytes]{};
    const sockaddr_in address = address_of(to);
    EXPECT_EQ(::sendto(sender_.get(), datagram, bytes, MSG_DONTWAIT,
                       reinterpret_cast<const sockaddr*>(&address), sizeof address),
              static_cast<ssize_t>(bytes));
  }
  void begin(ArrivalTime) noexcept override {}
  void datagram(std::span<const std::byte> bytes, const SocketAddress&) noexcept override {
    if (bytes.size() == stop_bytes) {
      stopped_ = true;
      return;
    }
    ++others_;
    send(flooded_, flood_bytes);
  }
  void end() noexcept override {}

  const FileDescriptor sender_ = open_on_loopback();
  std::unique_ptr<DatagramReceiver> receiver_;
  int flooded_ = -1;
  bool stopped_ = false;
  int others_ = 0;
};

INSTANTIATE_TEST_SUITE_P(Over, SocketTurnsTest, test::both_backends, test::backend_name);

TEST_P(SocketTurnsTest, ASenderWithoutEndKeepsNobodyOutOfTheSocketForGroups) {
  flood(sockets_->fd);
  stop(sockets_->groups.group_fd);
  EXPECT_TRUE(stop_comes_to_own_thread());
}

TEST_P(SocketTurnsTest, ASenderWithoutEndKeepsNobodyOutOfTheSocketForGroupsOfAThreadThatWaits) {
  flood(sockets_->fd);
  stop(sockets_->groups.group_fd);
  EXPECT_TRUE(stop_comes_to_waiting_thread());
}

TEST_P(SocketTurnsTest, ASenderToGroupsWithoutEndKeepsNobodyOutOfTheOwnSocket) {
  flood(sockets_->groups.group_fd);
  stop(sockets_->fd);
  EXPECT_TRUE(stop_comes_to_own_thread());
}

}  // namespace
}  // namespace sft::udp
