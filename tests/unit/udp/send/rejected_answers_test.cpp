// These tests check that answers are accepted for a destination only if its receiver has sent them.
#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <vector>

#include "tests/support/parse_datagram.h"
#include "tests/unit/udp/connections.h"
#include "tests/unit/udp/jobs.h"
#include "udp_transport/send/answers.h"

namespace sft::udp {
namespace {

using namespace std::chrono_literals;
using test::Bytes;

class RejectedAnswersTest : public testing::Test {
 protected:
  static constexpr std::uint32_t writer = 7;

  /// Sends a sample with that sequence.
  void send(std::uint64_t sequence) {
    const JobHandle job = test::make_job(*jobs_, sequence);
    const Channel::Posted posted = channel_->post(job, job->first, true);
    ASSERT_TRUE(posted.piece);
    static_cast<void>(channel_->finished(*posted.piece, now_));
    to_->sent(to_->connection(), 100, 1, 100, now_);
  }
  template <class Answer>
  void hear(const Answer& answer, const core::IpAddress& from) {
    Bytes bytes(datagram_bytes_min);
    encode(answer, bytes.data());
    bytes.resize(size_of(answer));
    static_cast<void>(hear_answer(side_, bytes, {from, 4444}, now_));
  }
  static std::size_t size_of(const Ack& ack) { return ack.bytes(); }
  static std::size_t size_of(const FlowReport&) { return report_bytes; }
  static std::size_t size_of(const GroupReport&) { return group_report_bytes; }
  std::uint64_t rejected() const { return side_.answers_rejected; }
  FlowReport true_report() const {
    for (const Bytes& bytes : connections_.sent()) {
      if (const auto mark = parse_as<FlowMark>(bytes))
        return {.flow = mark->flow,
                .position = mark->position,
                .window_bytes = 1'000'000,
                .datagrams = mark->datagrams,
                .came = mark->datagrams,
                .sent_at_ns = mark->sent_at_ns};
    }
    return {};
  }

  const core::IpAddress reader_{0x0A090002U}, unknown_sender_{0x0A090003U};
  Destination::Time now_{1h};
  test::Connections connections_;
  SendSide side_{std::make_unique<test::NoSender>(connections_), {.report_port = 9}};
  std::shared_ptr<JobPool> jobs_ = JobPool::make();
  ChannelDirectory channels_{writer, std::make_shared<WriterTally>(), side_.channels, 9};
  std::shared_ptr<Destination> to_ = side_.destinations.find({.ip = reader_, .port = 5000, .node = 3});
  std::shared_ptr<Channel> channel_ = channels_.find(to_, {1});
};

TEST_F(RejectedAnswersTest, AcksSweptOverChannelsAndOrdinalsLoseNothing) {
  for (std::uint64_t sequence = 1; sequence <= 10; ++sequence) send(sequence);
  std::uint64_t swept = 0;
  for (std::uint32_t channel = 0; channel < 1000; ++channel, ++swept)
    hear(Ack{.writer = writer, .channel = channel, .next = 11}, unknown_sender_);
  // The right channel number from an unknown address is rejected, too.
  for (std::uint64_t next = 1; next <= 11; ++next, ++swept)
    hear(Ack{.writer = writer, .channel = channel_->number(), .next = next}, unknown_sender_);
  // Wrong channel numbers from the reader's address are rejected, too.
  for (std::uint32_t channel = 0; channel < 1000; ++channel, ++swept)
    hear(Ack{.writer = writer, .channel = channel, .next = 11}, reader_);
  EXPECT_EQ(rejected(), swept);
  for (std::uint64_t ordinal = 1; ordinal <= 10; ++ordinal) EXPECT_TRUE(channel_->keeps(ordinal));
  hear(Ack{.writer = writer, .channel = channel_->number(), .next = 11}, reader_);
  EXPECT_FALSE(channel_->keeps(10));
  EXPECT_EQ(rejected(), swept);
}

TEST_F(RejectedAnswersTest, TheAckThatEndsAChannelSinceItIsOfWhatWasNeverSentIsCounted) {
  send(1);
  for (const std::uint64_t counted : {0, 1}) {
    hear(Ack{.writer = writer, .channel = channel_->number(), .next = 100}, reader_);
    EXPECT_EQ(rejected(), counted);
  }
}

TEST_F(RejectedAnswersTest, AnAckOfAWrongChannelMakesSamplesNameTheTrueOneInFull) {
  const auto next_is_in_short = [&] {
    const JobHandle job = test::make_job(*jobs_, 2);
    return channel_->post(job, job->first, true).piece->first.channel.in_short;
  };
  const std::uint32_t wrong = channel_->number() + 2048;
  send(1);
  hear(Ack{.writer = writer, .channel = channel_->number(), .next = 1}, reader_);
  EXPECT_TRUE(next_is_in_short());
  hear(Ack{.writer = writer, .channel = wrong, .next = 2}, unknown_sender_);
  EXPECT_TRUE(next_is_in_short());
  hear(Ack{.writer = writer, .channel = wrong, .next = 2}, reader_);
  EXPECT_FALSE(next_is_in_short());
  EXPECT_TRUE(channel_->keeps(1));
}

TEST_F(RejectedAnswersTest, ReportsThatRepeatNoMarkOpenNothing) {
  send(1);
  FlowReport guess = true_report();
  guess.sent_at_ns = now_.time_since_epoch().count();
  hear(guess, reader_);
  guess = true_report();
  ++guess.flow;
  hear(guess, reader_);
  EXPECT_EQ(rejected(), 2U);
  EXPECT_FALSE(to_->window().answers());
  hear(true_report(), reader_);
  EXPECT_TRUE(to_->window().answers());
}

TEST_F(RejectedAnswersTest, ReportsOnGroupsCountOnlyIfTheyAreOfAMemberOfAGroupThatExists) {
  constexpr std::uint32_t number = 2;
  const auto tally = std::make_shared<WriterTally>();
  const auto to_group =
      side_.destinations.find({.ip = core::IpAddress(private_groups + 1), .port = group_port});
  const auto group =
      MulticastGroup::make({writer, number, private_groups + 1}, std::make_shared<Lane>(to_group, 4, tally),
                           {{std::make_shared<Lane>(to_, 4, tally), nullptr}}, 9);
  side_.groups.add(group);
  const GroupReport report{writer, number, group->farewell(0).member, group->next_ordinal(now_)};
  GroupReport of_another_group = report, of_another_member = report;
  ++of_another_group.group;
  ++of_another_member.member;
  hear(of_another_group, reader_);
  EXPECT_EQ(rejected(), 1U);
  hear(of_another_member, reader_);
  EXPECT_EQ(rejected(), 2U);
  hear(report, unknown_sender_);
  EXPECT_EQ(rejected(), 3U);
  EXPECT_FALSE(group->hears(0));
  hear(report, reader_);
  EXPECT_EQ(rejected(), 3U);
  EXPECT_TRUE(group->hears(0));
}

TEST_F(RejectedAnswersTest, BytesThatAreNoAnswerCountAsMalformed) {
  send(1);
  Bytes bytes(report_bytes);
  encode(true_report(), bytes.data());
  static_cast<void>(hear_answer(side_, std::span(bytes).first(report_bytes - 1), {reader_, 4444}, now_));
  EXPECT_EQ(side_.malformed_answers, 1U);
  static_cast<void>(hear_answer(side_, bytes, {reader_, 4444}, now_));
  EXPECT_EQ(side_.malformed_answers, 1U);
  EXPECT_EQ(rejected(), 0U);
}

TEST_F(RejectedAnswersTest, TheReceiverMayHaveAnotherAddressAsItsReportShows) {
  send(1);
  const Ack ack{.writer = writer, .channel = channel_->number(), .next = 2};
  hear(ack, unknown_sender_);
  EXPECT_TRUE(channel_->keeps(1));
  hear(true_report(), unknown_sender_);
  hear(ack, unknown_sender_);
  EXPECT_FALSE(channel_->keeps(1));
}

}  // namespace
}  // namespace sft::udp
