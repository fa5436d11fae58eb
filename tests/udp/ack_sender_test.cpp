#include "udp_transport/ack_sender.h"

#include <gtest/gtest.h>

#include "connections.h"

namespace sft::udp {
namespace {

/// Counts how often it is connected to one address.
class CountingIo final : public DatagramSender {
 public:
  CountingIo(const SocketAddress& counted, int& count) : counted_(counted), count_(count) {}
  std::unique_ptr<Connection> connect(const SocketAddress& to) override {
    count_ += to == counted_ ? 1 : 0;
    return nowhere_.connect()(to);
  }
  std::unique_ptr<Connection> connect_group(const SocketAddress& group, const SocketAddress&) override {
    return connect(group);
  }
  void await(std::chrono::steady_clock::time_point) noexcept override {}
  void wake() noexcept override {}

 private:
  test::Connections nowhere_;
  const SocketAddress counted_;
  int& count_;
};

TEST(AckSenderTest, ForgetsNoneThatIsInUseForManyThatAreNot) {
  const SocketAddress honest{0x7F000001, 9};
  int connected = 0;
  AckSender sender(
      std::make_shared<SendSide>(std::make_unique<CountingIo>(honest, connected), DestinationLimits{}));
  for (std::uint16_t port = 1000; port < 3000; ++port) {
    sender.send({0x7F000001, port}, FlowReport{});
    if (port % 100 == 0) sender.send(honest, FlowReport{});
  }
  EXPECT_EQ(connected, 1);
}

}  // namespace
}  // namespace sft::udp
