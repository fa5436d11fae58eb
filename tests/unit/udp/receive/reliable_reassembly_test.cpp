// These tests check how the samples of one writer are put together in a channel, which at least one reader
// reads reliably.
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "tests/unit/udp/arrivals.h"
#include "tests/unit/udp/datagrams.h"
#include "udp_transport/receive/reassembly.h"

namespace sft::udp {
namespace {

using namespace detail;

using namespace std::chrono_literals;
using test::Bytes;
using test::fields;
using test::Image;
using test::lone_writer;
using test::make_image;

constexpr SocketAddress acks_to{{}, 7};

/// The sequence of each sample is its ordinal. sent() makes the datagrams of a sample, and receive() delivers
/// datagrams. `taken_` has the samples that a reader of the channel got. `at_once_` has the samples that a
/// best-effort reader got.
class ReliableReassemblyTest : public testing::Test {
 protected:
  using Sequences = std::vector<std::uint64_t>;

  ReliableReassemblyTest() { restart({}); }

  void restart(const ReassemblyLimits& limits, std::size_t pool_bytes = std::size_t{64} << 20) {
    pool_ = core::BufferPool::make(pool_bytes);
    reassembly_ = std::make_unique<Reassembly>(limits, pool_);
    read(true);
  }

  void read(bool reliably, std::size_t max_sample_bytes = 0, core::EndpointId writer = lone_writer) {
    Stream stream{writer, &test::type_support<Image>(), max_sample_bytes, {fields<Image>("*")}};
    stream.reliable = reliably;
    reassembly_->set_streams({&stream, 1});
    if (reliably) window().set_readers({1});
  }
  ArrivalWindow& window() { return *reassembly_->window(0); }

  static std::vector<Bytes> sent(std::uint64_t ordinal, std::size_t bytes, std::uint32_t channel = 1,
                                 core::EndpointId writer = lone_writer) {
    const Bytes body = test::encoded_body(make_image(bytes), fields<Image>("*"));
    const Segment whole{body.data(), body.size()};
    FirstHeader first{};
    first.label = {static_cast<std::uint32_t>(writer), static_cast<std::uint32_t>(ordinal), 0};
    first.flags = channel_follows;
    first.total = static_cast<std::uint32_t>(body.size());
    first.mask = fields<Image>("*").hash();
    first.stamp_ns = 5;
    first.channel = {channel, 0, ordinal};
    return test::cut({first, {}, {&whole, 1}}, 1472);
  }

  void receive(const Bytes& datagram) {
    const Arrival arrival = test::accept(*reassembly_, datagram, {now_, 1});
    if (arrival.sample && !arrival.in_channel) at_once_.push_back(arrival.sample->sequence);
    if (reassembly_->window(0) == nullptr) return;
    while (const core::SampleHandle sample =
               window().next(1, [](const auto&, std::uint64_t) { return true; })) {
      EXPECT_EQ(test::body_of(*sample), test::encoded_body(make_image(bytes_of(*sample)), sample->mask));
      taken_.push_back(sample->sequence);
    }
    window().release();
  }
  void receive(std::span<const Bytes> datagrams) {
    for (const Bytes& datagram : datagrams) receive(datagram);
  }
  void hear(std::uint64_t first, std::uint64_t end, std::uint32_t channel = 1) {
    Bytes bytes(heartbeat_bytes);
    encode(Heartbeat{static_cast<std::uint32_t>(lone_writer), channel, acks_to.port, first, end},
           bytes.data());
    test::accept(*reassembly_, bytes, {now_, 1}, acks_to);
  }
  const core::Transport::Counters& counted() const { return reassembly_->counters(); }

  Reassembly::Time now_ = Reassembly::Time{} + 1h;
  std::shared_ptr<core::BufferPool> pool_;
  std::unique_ptr<Reassembly> reassembly_;
  Sequences taken_;
  Sequences at_once_;

 private:
  /// Returns the number of data bytes of an image in the sample.
  static std::size_t bytes_of(const core::SampleBuffer& sample) {
    return sample.header().body_bytes - test::encoded_body(make_image(0), fields<Image>("*")).size();
  }
};

TEST_F(ReliableReassemblyTest, CompletesASampleThatNobodyWantsReliablyAnyMore) {
  const std::vector<Bytes> datagrams = sent(1, 10'000);
  receive(datagrams[0]);
  read(false);
  receive(datagrams[1]);
  receive(datagrams[1]);
  receive(std::span(datagrams).subspan(2));
  EXPECT_EQ(at_once_, Sequences{1});
}

TEST_F(ReliableReassemblyTest, GivesUpASampleThatNobodyWantsReliablyAnyMore) {
  receive(sent(1, 10'000)[0]);
  reassembly_->expire(now_ + 10s);
  EXPECT_EQ(counted().incomplete, 0U) << "it can come again";
  read(false);
  reassembly_->expire(now_ + 20s);
  EXPECT_EQ(counted().incomplete, 1U);
}

TEST_F(ReliableReassemblyTest, PutsInOrderSamplesThatBeganBeforeTheyWereWantedReliably) {
  const std::vector<Bytes> first = sent(1, 10'000), second = sent(2, 10'000);
  read(false);
  receive(first[0]);
  receive(second[0]);
  read(true);
  receive(first[0]);
  receive(std::span(second));
  EXPECT_EQ(taken_, Sequences{});
  receive(std::span(first).subspan(1));
  EXPECT_EQ(taken_, (Sequences{1, 2}));
  EXPECT_EQ(at_once_, Sequences{});
}

TEST_F(ReliableReassemblyTest, GoesOnWithAWriterThatIsReadAgainUnlessVeryManyOthersWereReadMeanwhile) {
  constexpr core::EndpointId one = 5000;
  core::EndpointId other = 5000;
  const auto read_a_sample_of = [&](core::EndpointId writer) {
    read(true, 0, writer);
    receive(sent(1, 100, 1, writer));
    EXPECT_TRUE(window().mark());
  };
  for (const auto& [others, is_remembered] : {std::pair(200, true), std::pair(300, false)}) {
    read_a_sample_of(one);
    for (int i = 0; i < others; ++i) read_a_sample_of(++other);
    read(true, 0, one);
    EXPECT_EQ(window().mark().has_value(), is_remembered) << others;
  }
}

TEST_F(ReliableReassemblyTest, TakesSamplesAfterHeartbeatsWhoseOrdinalsLeaveNoRoom) {
  for (const std::uint32_t channel : {1U, 2U, 3U, 4U}) hear(ordinal_max, ordinal_max, channel);
  receive(sent(1, 100, 5));
  receive(sent(ordinal_max, 100, 5));
  receive(sent(2, 100, 5));
  EXPECT_EQ(taken_, (Sequences{1, 2}));
  EXPECT_EQ(window().samples().slots().size(), 0U);
}

TEST_F(ReliableReassemblyTest, DoesNotGiveUpASampleForItsGaps) {
  restart({.gaps = 3});
  const std::vector<Bytes> datagrams = sent(1, 20'000);
  for (std::size_t i = 0; i < datagrams.size(); i += 2) receive(datagrams[i]);
  EXPECT_EQ(counted().over_limit, 4U) << "of 7: these can come again";
  receive(std::span(datagrams));
  EXPECT_EQ(taken_, Sequences{1});
}

TEST_F(ReliableReassemblyTest, DoesNotGiveUpASampleForParkedPartsWithTooManyGaps) {
  restart({.gaps = 3});
  const std::vector<Bytes> datagrams = sent(1, 20'000);
  for (std::size_t i = 2; i < datagrams.size(); i += 2) receive(datagrams[i]);
  receive(std::span(datagrams));
  EXPECT_EQ(taken_, Sequences{1});
}

TEST_F(ReliableReassemblyTest, DoesNotGiveUpASampleForAPartThatDoesNotBelongToIt) {
  const std::vector<Bytes> datagrams = sent(1, 10'000);
  Bytes beyond = datagrams[1];
  encode(FollowingHeader{{static_cast<std::uint32_t>(lone_writer), 1, 0}, 50'000}, beyond.data());
  receive(beyond);
  receive(std::span(datagrams));
  EXPECT_EQ(counted().malformed, 1U);
  EXPECT_EQ(taken_, Sequences{1});
}

TEST_F(ReliableReassemblyTest, HasMemoryForTheFirstMissingSampleWhenLaterOnesTookTheRest) {
  restart({}, std::size_t{4} << 20);
  read(true, 500'000);
  Sequences all = {1};
  std::uint64_t refused = 0;
  for (std::uint64_t ordinal = 2; refused == 0; ++ordinal) {
    receive(sent(ordinal, 400'000));
    counted().over_limit == 0 ? all.push_back(ordinal) : void(refused = ordinal);
  }
  EXPECT_GE(all.size(), 4U);
  EXPECT_EQ(taken_, Sequences{});
  receive(sent(1, 400'000));
  EXPECT_EQ(taken_, all);
  receive(sent(refused, 400'000));
  all.push_back(refused);
  EXPECT_EQ(taken_, all) << "the one that there was no memory for comes later, and is not lost";
}

/// A large sample of which every second datagram is lost has more gaps than may be requested at a time.
TEST_F(ReliableReassemblyTest, AsksForAtMostAsManyPartsAsEightAcksHold) {
  constexpr std::size_t parts_max = 8 * missing_max;
  const std::vector<Bytes> datagrams = sent(1, 3 * parts_max * 1456);
  hear(1, 2);
  for (std::size_t i = 0; i < datagrams.size(); i += 2) receive(datagrams[i]);
  now_ = std::max(now_ + 2ms, reassembly_->next_answer());
  std::size_t acks = 0, parts = 0;
  reassembly_->answer(now_, [&](const SocketAddress&, const Ack& ack) {
    ++acks;
    parts += ack.missing_count;
  });
  EXPECT_EQ(parts, parts_max);
  EXPECT_EQ(acks, 8U);
}

/// The reader requests three parts. One of them comes several times, so the request was too early. After
/// that, the reader waits longer before it requests parts.
TEST_F(ReliableReassemblyTest, WaitsLongerIfPartsThatItAskedForComeTwice) {
  const std::vector<Bytes> datagrams = sent(1, 20'000);
  hear(1, 2);
  for (std::size_t i = 0; i < datagrams.size(); ++i) {
    if (i != 3 && i != 5 && i != 7) receive(datagrams[i]);
  }
  now_ += 2ms;
  reassembly_->answer(now_, [](const SocketAddress&, const Ack& ack) { EXPECT_EQ(ack.missing_count, 3U); });
  for (int i = 0; i < 4; ++i) receive(datagrams[3]);
  const auto noticed = now_ += 1s;
  receive(sent(3, 100));
  now_ = noticed + 3ms;
  std::vector<std::uint32_t> asked;
  const auto note = [&](const SocketAddress&, const Ack& ack) {
    for (const Missing& part : ack.parts()) asked.push_back(part.ordinal);
  };
  reassembly_->answer(now_, note);
  EXPECT_EQ(std::ranges::count(asked, 2U), 0);
  now_ = noticed + 4ms;
  reassembly_->answer(now_, note);
  EXPECT_EQ(std::ranges::count(asked, 2U), 1);
}

TEST_F(ReliableReassemblyTest, IgnoresSamplesOfAGroupThatItWasNotOffered) {
  FirstHeader first{};
  first.label = {static_cast<std::uint32_t>(lone_writer), 5, 0};
  first.flags = group_follows;
  first.mask = fields<Image>("*").hash();
  first.group = {3, 0, 1};
  const Bytes body = test::encoded_body(make_image(10'000), fields<Image>("*"));
  const Segment whole{body.data(), body.size()};
  first.total = static_cast<std::uint32_t>(body.size());
  receive(test::cut({first, {}, {&whole, 1}}, 1472));
  EXPECT_FALSE(reassembly_->next_expiry()) << "something of it is kept";
  reassembly_->expire(now_ + 10s);
  EXPECT_EQ(counted().incomplete, 0U);
}

TEST_F(ReliableReassemblyTest, AnswersOnlyWhereTheWritersNodeCanBeReached) {
  const core::IpAddress its{0x0A630102}, of_a_third{0x0A630109};
  Stream stream{lone_writer, &test::type_support<Image>(), 0, {fields<Image>("*")}};
  stream.reliable = true;
  stream.node = {true, {{its, 7000}}, false};
  reassembly_->set_streams({&stream, 1});
  std::vector<SocketAddress> answered;
  const auto hear_from = [&](const core::IpAddress& ip, std::uint16_t port) {
    Bytes bytes(heartbeat_bytes);
    encode(Heartbeat{static_cast<std::uint32_t>(lone_writer), 1, port, 1, 2}, bytes.data());
    test::accept(*reassembly_, bytes, {now_, 1}, {ip, 9});
    answered.clear();
    reassembly_->answer(now_, [&](const SocketAddress& to, const Ack&) { answered.push_back(to); });
  };
  hear_from(its, 4000);
  EXPECT_EQ(answered, (std::vector<SocketAddress>{{its, 4000}}));
  hear_from(of_a_third, 4000);
  EXPECT_EQ(answered, (std::vector<SocketAddress>{{its, 4000}}));
  hear_from(its, 5000);
  EXPECT_EQ(answered, (std::vector<SocketAddress>{{its, 4000}, {its, 5000}}))
      << "one word does not turn acks away";
  hear_from(its, 5000);
  EXPECT_EQ(answered, (std::vector<SocketAddress>{{its, 5000}}));
  EXPECT_FALSE(reassembly_->report_address(of_a_third, 4000)) << "nothing of a writer came from there";
  reassembly_->came_from(0, of_a_third);
  EXPECT_EQ(reassembly_->report_address(of_a_third, 4000), (SocketAddress{its, 4000}));
}

TEST_F(ReliableReassemblyTest, AnswersWithAtMostThreeTimesAsManyBytesAsCame) {
  std::size_t came = 0, answered = 0;
  const auto let_pass = [&](std::chrono::milliseconds duration) {
    for (const auto end = now_ + duration; now_ < end; now_ += 10ms)
      reassembly_->answer(now_, [&](const SocketAddress&, const Ack& ack) { answered += ack.bytes(); });
  };
  const std::vector<Bytes> large = sent(1, 50'000);
  receive(large[0]);
  came += large[0].size();
  for (int i = 0; i < 5; ++i) {
    hear(1, 4000);
    came += heartbeat_bytes;
    let_pass(4s);
    EXPECT_GT(answered, 0U);
    EXPECT_LE(answered, 3 * came);
  }
  for (const Bytes& datagram : large) receive(datagram);
  answered = 0;
  let_pass(100ms);
  EXPECT_GT(answered, 2000U) << "who sends what was asked for is asked for more";
}

}  // namespace
}  // namespace sft::udp
