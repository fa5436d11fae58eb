#include "udp_transport/io/socket_sender.h"

#include <dirent.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/resource.h>

#include <cerrno>
#include <vector>

namespace sft::udp {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

std::size_t open_files() {
  std::size_t n = 0;
  DIR* files = ::opendir("/proc/self/fd");
  while (::readdir(files) != nullptr) ++n;
  ::closedir(files);
  return n;
}

class SocketSenderTest : public testing::Test {
 protected:
  static std::shared_ptr<const UdpSocket> open_socket() {
    return open_udp_socket({.bind = {INADDR_LOOPBACK, 0}, .receive_buffer_bytes = 200'000}).value();
  }
  static SendOutcome send(Connection& connection) {
    std::byte bytes[100]{};
    const iovec part{bytes, sizeof bytes};
    const OutgoingBatch batch{.parts = {&part, 1}};
    return connection.try_send({&batch, 1}).outcome;
  }
  static std::size_t received(const UdpSocket& socket) {
    std::byte bytes[200];
    std::size_t n = 0;
    while (::recv(socket.fd.get(), bytes, sizeof bytes, MSG_DONTWAIT) > 0) ++n;
    return n;
  }

  std::unique_ptr<DatagramSender> sender_ = open_socket_sender(open_socket()).value();
  std::shared_ptr<const UdpSocket> receiver_ = open_socket();
  SocketAddress there_{INADDR_LOOPBACK, receiver_->port};
};

TEST_F(SocketSenderTest, OpensNoMoreSocketsThanItMay) {
  const std::size_t before = open_files();
  std::vector<std::unique_ptr<Connection>> connections;
  for (std::size_t i = 0; i < sending_sockets_max + 10; ++i) connections.push_back(sender_->connect(there_));
  EXPECT_EQ(open_files(), before + sending_sockets_max);
  for (const auto& connection : connections) {
    EXPECT_EQ(send(*connection), SendOutcome::sent);
    EXPECT_EQ(received(*receiver_), 1U);
  }
  connections.clear();
  EXPECT_EQ(open_files(), before);
  connections.push_back(sender_->connect(there_));
  EXPECT_EQ(open_files(), before + 1);
}

/// In the second round all sockets are taken, so the datagrams use the one socket that all further
/// connections share.
TEST_F(SocketSenderTest, SendsOnToAnotherAddressOfEitherFamily) {
  const auto at_ipv6 = open_udp_socket({.bind = {core::loopback_ipv6, 0}, .receive_buffer_bytes = 200'000});
  if (!at_ipv6) GTEST_SKIP() << at_ipv6.error().message;
  const auto sender = open_socket_sender(open_udp_socket({}).value()).value();
  std::vector<std::unique_ptr<Connection>> others;
  for (const std::size_t taken : {std::size_t{0}, sending_sockets_max}) {
    while (others.size() < taken) others.push_back(sender->connect(there_));
    const auto connection = sender->connect(there_);
    for (int i = 0; i < 2; ++i) {
      EXPECT_EQ(send(*connection), SendOutcome::sent);
      EXPECT_EQ(received(*receiver_), 1U);
      connection->redirect({core::loopback_ipv6, (*at_ipv6)->port});
      EXPECT_EQ(send(*connection), SendOutcome::sent);
      EXPECT_EQ(received(**at_ipv6), 1U);
      connection->redirect(there_);
    }
  }
}

TEST_F(SocketSenderTest, SharesASocketWhereTheProcessMayOpenNoMore) {
  DatagramSender& sender = *sender_;
  const SocketAddress there = there_;
  const auto first = sender.connect(there);
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_NOFILE, &before), 0);
  const rlimit none{.rlim_cur = 0, .rlim_max = before.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &none), 0);
  const auto second = sender.connect(there);
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &before), 0);
  second->reconnect();
  EXPECT_EQ(send(*second), SendOutcome::sent);
  EXPECT_EQ(received(*receiver_), 1U);
}

TEST_F(SocketSenderTest, SaysWhichOfManyItSent) {
  const auto connection = sender_->connect(there_);
  std::vector<std::byte> bytes(65'508);
  const iovec short_part{bytes.data(), 100}, long_part{bytes.data(), bytes.size()};
  std::vector<OutgoingBatch> batches(20, OutgoingBatch{.parts = {&short_part, 1}});
  EXPECT_EQ(connection->try_send(batches).batches, 20U);
  batches[13].parts = {&long_part, 1};
  const Connection::Sent sent = connection->try_send(batches);
  EXPECT_EQ(sent.batches, 13U);
  EXPECT_EQ(sent.outcome, SendOutcome::too_long);
  EXPECT_EQ(received(*receiver_), 33U);
}

TEST_F(SocketSenderTest, GoesOnAfterItReconnected) {
  const auto connection = sender_->connect(there_);
  for (int i = 0; i < 3; ++i) {
    connection->reconnect();
    EXPECT_EQ(send(*connection), SendOutcome::sent);
  }
  EXPECT_EQ(received(*receiver_), 3U);
}

TEST_F(SocketSenderTest, SendsToAPortThatNobodyHadAMomentAgo) {
  const auto connection = sender_->connect(there_);
  receiver_.reset();
  // The system refuses this datagram later, because no socket has the port.
  EXPECT_EQ(send(*connection), SendOutcome::sent);
  receiver_ = open_udp_socket({.bind = there_}).value();
  EXPECT_EQ(send(*connection), SendOutcome::sent);
  EXPECT_EQ(received(*receiver_), 1U);
}

TEST_F(SocketSenderTest, ReturnsOnceThereIsRoom) {
  const auto connection = sender_->connect(there_);
  EXPECT_FALSE(connection->full());
  connection->wait_for_room();
  EXPECT_TRUE(connection->full());
  sender_->await(Clock::now() + 20s);
  EXPECT_FALSE(connection->full());
}

TEST_F(SocketSenderTest, ReturnsAtTheDeadlineAndWhenItIsWoken) {
  const auto deadline = Clock::now() + 1ms;
  sender_->await(deadline);
  EXPECT_GE(Clock::now(), deadline);
  sender_->wake();
  sender_->await(Clock::time_point::max());
}

TEST(SendOutcome, OfSegmentsLongerThanThePathTakesIsTooLongOnAllKernels) {
  EXPECT_EQ(outcome_of(EMSGSIZE, true), SendOutcome::too_long);
  EXPECT_EQ(outcome_of(EINVAL, true), SendOutcome::too_long);
  EXPECT_EQ(outcome_of(EINVAL, false), SendOutcome::failed);
  EXPECT_EQ(outcome_of(EIO, true), SendOutcome::no_segments);
  EXPECT_EQ(outcome_of(EAGAIN, true), SendOutcome::would_wait);
}

}  // namespace
}  // namespace sft::udp
