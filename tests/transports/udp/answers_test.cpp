// Acks and reports are sent to the right port, and the sender receives them.
#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "tests/support/parse_datagram.h"
#include "tests/transports/udp/endpoints.h"
#include "tests/transports/udp/faulty_io.h"
#include "tests/transports/udp/transport_fixture.h"
#include "udp_transport/io/socket_sender.h"
#include "udp_transport/io/udp_socket.h"

namespace sft::udp {
namespace {

using test::eventually;
using test::loopback_address;
using test::make_image;
using test::Publisher;
using test::Subscriber;

/// Records the port at which the sender requests answers. Counts the answers and marks that arrive at the
/// port for samples.
class AnswerMonitor final : public test::PassingReceiver {
 public:
  struct Seen {
    std::atomic<unsigned> port{0}, here{0}, marks{0};
  };
  AnswerMonitor(std::unique_ptr<DatagramReceiver> inner, Seen& seen)
      : PassingReceiver(std::move(inner)), seen_(seen) {}

 private:
  void datagram(std::span<const std::byte> bytes, const SocketAddress& from) noexcept override {
    if (const auto heartbeat = parse_as<Heartbeat>(bytes)) seen_.port = heartbeat->port;
    const auto kind = kind_of(bytes);
    if (kind == DatagramKind::mark) ++seen_.marks;
    if (kind == DatagramKind::ack || kind == DatagramKind::report) ++seen_.here;
    pass_on(bytes, from);
  }

  Seen& seen_;
};

class AnswersTest : public TransportTest {
 protected:
  std::unique_ptr<core::Network> open(AnswerMonitor::Seen& seen, std::uint16_t port = 0) {
    return TransportTest::open({.port = port}, [&](DatagramIo io) {
      io.receiver = std::make_unique<AnswerMonitor>(std::move(io.receiver), seen);
      return io;
    });
  }

  /// Sends enough samples to make the receiver send reports and acks.
  void transfer(core::Network& there, core::Network& here) {
    Subscriber subscriber(here, {"*"});
    Publisher publisher(there);
    subscriber.listen_reliably_to(publisher.id());
    publisher.serve({{loopback_address(here), "*", true}});
    for (int n = 0; n < 20; ++n) ASSERT_EQ(publisher.publish(make_image(300'000)), core::SendStatus::sent);
    ASSERT_EQ(subscriber.await_sequences(20), first_numbers(20));
    ASSERT_TRUE(eventually([&] { return seen_here_.port != 0; }));
  }

  /// Sends acks to the port at which the transport receives samples.
  static void acknowledge_what_was_never_sent(const core::Network& there, int times) {
    std::array<std::byte, 256> bytes{};
    const Ack ack{.writer = 1, .channel = 1, .next = 1};
    encode(ack, bytes.data());
    const core::UdpAddress address = loopback_address(there);
    const auto socket = open_udp_socket({.bind = {address.ip, 0}}).value();
    const auto sender = open_socket_sender(socket).value();
    const auto connection = sender->connect({address.ip, address.port});
    for (int i = 0; i < times; ++i)
      ASSERT_EQ(send_one(*connection, std::span(bytes).first(ack.bytes())), SendOutcome::sent);
  }

  AnswerMonitor::Seen seen_there_, seen_here_;
};

INSTANTIATE_TEST_SUITE_P(Backends, AnswersTest, all_ways, way_name);

TEST_P(AnswersTest, ComeToAPortOfTheirOwnAndWakeNobodyWhoReceivesSamples) {
  const auto there = open(seen_there_), here = open(seen_here_);
  transfer(*there, *here);
  EXPECT_NE(seen_here_.port, there->addresses().at(0).port);
  EXPECT_EQ(seen_there_.here, 0U);
}

// Firewalls and address translators let answers pass only at the chosen port.
TEST_P(AnswersTest, ComeToThePortThatWasChosenWhereOneWas) {
  // This transport is closed at once, so its port is free.
  const std::uint16_t port = TransportTest::open()->addresses().at(0).port;
  const auto there = open(seen_there_, port), here = open(seen_here_);
  transfer(*there, *here);
  EXPECT_EQ(seen_here_.port, port);
  EXPECT_GT(seen_there_.here, 0U);
}

TEST_P(AnswersTest, AreAskedForBeforeThereIsASample) {
  const auto there = open(seen_there_), here = open(seen_here_);
  Subscriber subscriber(*here, {"*"});
  Publisher publisher(*there);
  subscriber.listen_to(publisher.id());
  publisher.serve({{loopback_address(*here)}});
  EXPECT_TRUE(eventually([&] { return seen_here_.marks > 0; }));
}

TEST_P(AnswersTest, AreCountedAndNotHeardAtThePortForSamples) {
  const auto there = open(seen_there_);
  const auto before = there->counters().malformed;
  acknowledge_what_was_never_sent(*there, 1);
  EXPECT_TRUE(eventually([&] { return there->counters().malformed == before + 1; }));
  EXPECT_EQ(there->counters().rejected, 0U);
}

TEST_P(AnswersTest, AreCountedWhereNothingWasSentThatTheyAnswer) {
  // This transport is closed at once, so its port is free.
  const std::uint16_t port = TransportTest::open()->addresses().at(0).port;
  const auto there = open(seen_there_, port);
  acknowledge_what_was_never_sent(*there, 3);
  EXPECT_TRUE(eventually([&] { return there->counters().rejected == 3; }));
  EXPECT_EQ(there->counters().malformed, 0U);
}

TEST_P(AnswersTest, AreCountedWhereTheyMakeNoSense) {
  const auto there = open(seen_there_), here = open(seen_here_);
  transfer(*there, *here);
  const auto stranger = TransportTest::open();
  const auto before = there->counters().malformed;
  Publisher publisher(*stranger);  // will send samples to the port for answers
  core::UdpAddress wrong = loopback_address(*there);
  wrong.port = static_cast<std::uint16_t>(seen_here_.port);
  publisher.serve({{wrong}});
  publisher.publish(make_image(1));
  EXPECT_TRUE(eventually([&] { return there->counters().malformed == before + 2; }))
      << "the sample, and the mark behind it";
}

}  // namespace
}  // namespace sft::udp
