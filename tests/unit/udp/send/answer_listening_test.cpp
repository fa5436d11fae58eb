// These tests check how the sending thread handles the answers that have come.
#include <gtest/gtest.h>

#include <vector>

#include "tests/unit/udp/connections.h"
#include "udp_transport/send/flow_sender.h"

namespace sft::udp {
namespace {

/// A sender that receives `answers` answers of one byte, with the values 0, 1, ...
class AnsweredSender final : public test::NoSender {
 public:
  using NoSender::NoSender;
  Answer take_answer(std::span<std::byte> to) noexcept override {
    if (taken == answers) return {};
    to[0] = static_cast<std::byte>(taken++);
    return {.bytes = 1, .from = {.ip = 0x7F000001, .port = 5}};
  }
  int answers = 0;
  int taken = 0;
};

class AnswerListeningTest : public testing::Test {
 protected:
  void set_handler(Wake wake) {
    sender.set_handler([this, wake](std::span<const std::byte> datagram, const SocketAddress& from, auto) {
      EXPECT_EQ(from.port, 5);
      EXPECT_EQ(datagram.size(), 1U);
      heard.push_back(std::to_integer<int>(datagram[0]));
      return wake;
    });
  }

  test::Connections connections;
  AnsweredSender io{connections};
  NextRound round;
  RateLimit limit{0};
  LocalTurns local_turns;
  FlowSender sender{limit, local_turns, io, round};
  std::vector<int> heard;
};

TEST_F(AnswerListeningTest, HearsAllThatHasCome) {
  set_handler(Wake::none);
  io.answers = 3;
  sender.listen();
  EXPECT_EQ(heard, (std::vector{0, 1, 2}));
  EXPECT_EQ(round.time(), NextRound::Time::max()) << "nothing may go on";
}

TEST_F(AnswerListeningTest, AsksForARoundAtOnceIfSomethingMayGoOn) {
  set_handler(Wake::look);
  sender.listen();
  EXPECT_EQ(round.time(), NextRound::Time::max());
  io.answers = 1;
  sender.listen();
  EXPECT_EQ(round.time(), NextRound::Time{});
}

TEST_F(AnswerListeningTest, LetsStrangersKeepItBusyForAWhileOnly) {
  set_handler(Wake::none);
  io.answers = 100;
  sender.listen();
  EXPECT_EQ(heard.size(), 64U);
  sender.listen();
  EXPECT_EQ(heard.size(), 100U);
}

TEST_F(AnswerListeningTest, DropsAnswersIfNobodyHearsThem) {
  io.answers = 3;
  sender.listen();
  EXPECT_EQ(io.taken, 3);
}

}  // namespace
}  // namespace sft::udp
