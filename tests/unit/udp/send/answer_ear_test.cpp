#include "udp_transport/send/answer_ear.h"

#include <gtest/gtest.h>

#include <vector>

#include "tests/unit/udp/connections.h"

namespace sft::udp {
namespace {

/// A sender to which answers of one byte come, counted from 0.
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

class AnswerEarTest : public testing::Test {
 protected:
  void tell(Wake wake) {
    ear.tell([this, wake](std::span<const std::byte> datagram, const SocketAddress& from, auto) {
      EXPECT_EQ(from.port, 5);
      EXPECT_EQ(datagram.size(), 1U);
      heard.push_back(std::to_integer<int>(datagram[0]));
      return wake;
    });
  }

  test::Connections connections;
  AnsweredSender io{connections};
  NextRound round;
  AnswerEar ear{io, round};
  std::vector<int> heard;
};

TEST_F(AnswerEarTest, HearsAllThatHasCome) {
  tell(Wake::none);
  io.answers = 3;
  ear.listen();
  EXPECT_EQ(heard, (std::vector{0, 1, 2}));
  EXPECT_EQ(round.time(), NextRound::Time::max()) << "nothing may go on";
}

TEST_F(AnswerEarTest, AsksForARoundAtOnceIfSomethingMayGoOn) {
  tell(Wake::look);
  ear.listen();
  EXPECT_EQ(round.time(), NextRound::Time::max());
  io.answers = 1;
  ear.listen();
  EXPECT_EQ(round.time(), NextRound::Time{});
}

TEST_F(AnswerEarTest, LetsStrangersKeepItBusyForAWhileOnly) {
  tell(Wake::none);
  io.answers = 100;
  ear.listen();
  EXPECT_EQ(heard.size(), 64U);
  ear.listen();
  EXPECT_EQ(heard.size(), 100U);
}

TEST_F(AnswerEarTest, DropsAnswersIfNobodyHearsThem) {
  io.answers = 3;
  ear.listen();
  EXPECT_EQ(io.taken, 3);
}

}  // namespace
}  // namespace sft::udp
