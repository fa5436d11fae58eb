#include "udp_transport/send/answer_sender.h"

#include <gtest/gtest.h>

#include "tests/unit/udp/connections.h"

namespace sft::udp {
namespace {

/// Counts the connections that are made, and the datagrams that are sent without a connection.
class CountingIo final : public DatagramSender {
 public:
  struct Counts {
    std::size_t connections = 0;
    std::size_t datagrams = 0;
    std::size_t bytes = 0;
    SocketAddress last{};
  };
  explicit CountingIo(Counts& counts) : counts_(counts) {}
  std::unique_ptr<Connection> connect(const SocketAddress& to) override {
    ++counts_.connections;
    return nowhere_.connect()(to);
  }
  std::unique_ptr<Connection> connect_group(const SocketAddress& group, const SocketAddress&) override {
    return connect(group);
  }
  void send_to(const SocketAddress& to, std::span<const std::byte> datagram) noexcept override {
    ++counts_.datagrams;
    counts_.bytes += datagram.size();
    counts_.last = to;
  }
  void await(std::chrono::steady_clock::time_point) noexcept override {}
  void wake() noexcept override {}

 private:
  test::Connections nowhere_;
  Counts& counts_;
};

TEST(AnswerSenderTest, AnswersManyWithoutAConnectionToAnyOfThem) {
  CountingIo::Counts counts;
  AnswerSender sender(std::make_shared<SendSide>(std::make_unique<CountingIo>(counts), DestinationLimits{}));
  for (std::uint16_t port = 1000; port < 3000; ++port) sender.send({0x7F000001, port}, FlowReport{});
  EXPECT_EQ(counts.connections, 0U);
  EXPECT_EQ(counts.datagrams, 2000U);
  EXPECT_EQ(counts.bytes, 2000 * report_bytes);
  const SocketAddress last{0x7F000001, 2999};
  EXPECT_EQ(counts.last, last);
}

TEST(AnswerSenderTest, SendsAcksAndReportsOfGroupsAsLongAsTheyAre) {
  CountingIo::Counts counts;
  AnswerSender sender(std::make_shared<SendSide>(std::make_unique<CountingIo>(counts), DestinationLimits{}));
  Ack ack{.writer = 1, .channel = 1, .next = 2};
  ack.missing[ack.missing_count++] = {2, 0, 0};
  sender.send({0x7F000001, 9}, ack);
  sender.send({0x7F000001, 9}, GroupReport{});
  EXPECT_EQ(counts.bytes, ack.bytes() + group_report_bytes);
}

}  // namespace
}  // namespace sft::udp
