// These tests check the datagrams that arrive from one writer: the samples that are made from the datagrams,
// and the requests for missing parts.
#include "udp_transport/receive/incoming_writer.h"

#include <gtest/gtest.h>
#include <malloc.h>

#include <algorithm>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "tests/support/test_seed.h"
#include "tests/unit/udp/datagrams.h"

namespace sft::udp {
namespace {

using namespace detail;

using namespace std::chrono_literals;
using test::Bytes;
using test::fields;
using test::Image;
using test::lone_writer;
using test::make_image;
using test::short_id;

constexpr std::size_t stream_index = 3;
const SocketAddress home{core::IpAddress(0x0A630102), 4000}, other_home{core::IpAddress(0x0A630103), 4000};

/// The sequence of each sample equals its ordinal. sent() makes the datagrams of a sample, receive()
/// delivers datagrams, and ask() returns the parts that are requested from the writer.
class IncomingWriterTest : public sft::test::RandomTest {
 protected:
  IncomingWriterTest() { restart({}); }

  void restart(const ReassemblyLimits& limits, std::size_t memory_bytes = std::size_t{64} << 20) {
    writer_.reset();
    shared_ = std::make_unique<ReassemblyMemory>(limits, core::BufferPool::make(memory_bytes));
    writer_ = make_writer();
  }
  std::unique_ptr<IncomingWriter> make_writer() {
    auto made = std::make_unique<IncomingWriter>(*shared_);
    made->follow({lone_writer, &test::type_support<Image>(), 100'000, {fields<Image>("*")}}, stream_index);
    return made;
  }
  void read_reliably() {
    writer_->open_window({});
    writer_->window()->set_readers({1});
  }

  static FirstHeader header(std::uint32_t ordinal, bool reliable) {
    FirstHeader first{};
    first.label = {short_id, ordinal, 0};
    first.flags = reliable ? channel_follows : std::uint8_t{0};
    first.mask = fields<Image>("*").hash();
    first.stamp_ns = 5;
    if (reliable) first.channel = {1, 0, ordinal};
    return first;
  }
  static std::vector<Bytes> sent(std::uint32_t ordinal, std::size_t bytes, bool reliable = false,
                                 BodyRange range = {}) {
    return cut(header(ordinal, reliable), bytes, range);
  }
  static std::vector<Bytes> cut(FirstHeader first, std::size_t bytes, BodyRange range = {}) {
    const Bytes body = test::encoded_body(make_image(bytes, first.label.sequence), fields<Image>("*"));
    const Segment whole{body.data(), body.size()};
    first.total = static_cast<std::uint32_t>(body.size());
    std::vector<Bytes> datagrams;
    Fragmenter fragments({first, {}, {&whole, 1}}, 1472, range);
    for (Batch batch; !fragments.done();) {
      fragments.next(batch);
      test::append_datagrams(batch.parts(), batch.segment_bytes(), datagrams);
    }
    return datagrams;
  }

  Arrival receive(IncomingWriter& to, const Bytes& bytes) {
    AnyDatagram datagram = decode(bytes);
    const Envelope envelope{home, {now_, 77}, bytes.size()};
    ++shared_->datagrams;
    if (auto* following = std::get_if<Following>(&datagram)) return to.accept(*following, envelope);
    return to.accept(std::get<Datagram>(datagram), envelope);
  }
  void receive(const Bytes& bytes) {
    const Arrival arrival = receive(*writer_, bytes);
    if (arrival.sample) taken_.push_back(arrival.sample);
  }
  void receive(const std::vector<Bytes>& datagrams) {
    for (const Bytes& datagram : datagrams) receive(datagram);
  }
  void hear(std::uint64_t first, std::uint64_t end, const SocketAddress& answers_to = home) {
    const Heartbeat heartbeat{short_id, 1, answers_to.port, first, end};
    writer_->accept(heartbeat, answers_to, {home, {now_, 77}, heartbeat_bytes});
  }

  /// Advances the time by `after`. Returns the parts that are requested from the writer then.
  std::vector<Missing> ask(std::chrono::milliseconds after) {
    now_ += after;
    std::vector<Missing> asked;
    answered_.clear();
    writer_->answer(now_, [&](const SocketAddress& to, const Ack& ack) {
      answered_.push_back(to);
      asked.insert(asked.end(), ack.parts().begin(), ack.parts().end());
    });
    return asked;
  }
  std::vector<std::uint64_t> taken() const {
    std::vector<std::uint64_t> sequences;
    for (const core::SampleHandle& sample : taken_) sequences.push_back(sample->header().sequence);
    return sequences;
  }
  using Sequences = std::vector<std::uint64_t>;

  IncomingWriter::Time now_{1h};
  std::unique_ptr<ReassemblyMemory> shared_;
  std::unique_ptr<IncomingWriter> writer_;
  std::vector<core::SampleHandle> taken_;
  std::vector<SocketAddress> answered_;
};

TEST_F(IncomingWriterTest, BringsASampleOfOneDatagramAtOnce) {
  const Arrival arrival = receive(*writer_, sent(9, 100).front());
  ASSERT_TRUE(arrival.sample);
  EXPECT_EQ(arrival.stream, stream_index);
  EXPECT_FALSE(arrival.in_channel);
  EXPECT_EQ(arrival.sample->header().writer, lone_writer);
  EXPECT_EQ(arrival.sample->header().sequence, 9U);
  EXPECT_EQ(arrival.sample->receive_stamp_ns, 77);
  EXPECT_EQ(test::body_of(*arrival.sample), test::encoded_body(make_image(100, 9), fields<Image>("*")));
}

TEST_F(IncomingWriterTest, PutsSamplesTogetherInWhateverOrderTheirDatagramsCome) {
  constexpr std::uint32_t samples = 4;  // the limit of unfinished samples
  for (std::uint64_t round = sft::test::test_rounds(20); round > 0; --round) {
    restart({});
    taken_.clear();
    std::vector<Bytes> datagrams;
    for (std::uint32_t ordinal = 1; ordinal <= samples; ++ordinal) {
      for (Bytes& datagram : sent(ordinal, random() % 20'000)) datagrams.push_back(std::move(datagram));
    }
    std::ranges::shuffle(datagrams, random);
    receive(datagrams);
    Sequences sequences = taken();
    std::ranges::sort(sequences);
    ASSERT_EQ(sequences, (Sequences{1, 2, 3, 4}));
    EXPECT_FALSE(shared_->next_expiry()) << "something is left over";
  }
}

TEST_F(IncomingWriterTest, FitsFollowingDatagramsOfSamplesThatHaveBegunOnly) {
  const std::vector<Bytes> datagrams = sent(1, 5000);
  const Following last = std::get<Following>(decode(datagrams.back()));
  EXPECT_FALSE(writer_->fits(last));
  receive(datagrams.front());
  EXPECT_TRUE(writer_->fits(last));
}

TEST_F(IncomingWriterTest, FitsFirstDatagramsByTheirMaskAndLengthOrByTheirChannel) {
  const auto first_of = [](const std::vector<Bytes>& datagrams) {
    return std::get<Datagram>(decode(datagrams.front()));
  };
  EXPECT_TRUE(writer_->fits(first_of(sent(1, 5000))));
  EXPECT_FALSE(writer_->fits(first_of(sent(1, 200'000)))) << "longer than the writer announced";
  FirstHeader other_mask = header(1, true);
  other_mask.mask = fields<Image>("data").hash();
  EXPECT_FALSE(writer_->fits(first_of(cut(other_mask, 5000))));
  read_reliably();
  hear(1, 1);
  EXPECT_TRUE(writer_->follows(1));
  EXPECT_FALSE(writer_->follows(2));
  EXPECT_TRUE(writer_->fits(first_of(cut(other_mask, 5000)))) << "the channel is the one that is followed";
}

TEST_F(IncomingWriterTest, SharesTheLimitOnDatagramsThatCameTooEarlyWithOtherWriters) {
  restart({.parked_bytes = 6000});
  std::unique_ptr<IncomingWriter> other = make_writer();
  const std::vector<Bytes> datagrams = sent(1, 5000);
  for (std::size_t i = 1; i < datagrams.size(); ++i) receive(*other, datagrams[i]);
  EXPECT_EQ(shared_->counters.over_limit, 0U);
  receive(std::vector<Bytes>(datagrams.begin() + 1, datagrams.end()));
  EXPECT_EQ(shared_->counters.over_limit, 1U);
  other.reset();
  receive(sent(2, 5000).back());
  EXPECT_EQ(shared_->counters.over_limit, 1U) << "what is dropped makes room";
}

TEST_F(IncomingWriterTest, DropsAndCountsASampleThatMakesNoProgress) {
  receive(sent(1, 5000).front());
  std::optional<IncomingWriter::Time> next;
  writer_->expire(now_ + 499ms, next);
  EXPECT_EQ(shared_->counters.incomplete, 0U);
  EXPECT_EQ(next, now_ + 500ms);
  writer_->expire(now_ + 500ms, next);
  EXPECT_EQ(shared_->counters.incomplete, 1U);
  EXPECT_FALSE(shared_->next_expiry());
}

TEST_F(IncomingWriterTest, AnswersNobodyBeforeAHeartbeatNamesAnAddress) {
  read_reliably();
  receive(sent(2, 100, true));
  EXPECT_EQ(writer_->next_answer(), IncomingWriter::Time::max());
  ask(1s);
  EXPECT_TRUE(answered_.empty());
  hear(1, 3);
  ask(1s);
  EXPECT_EQ(answered_, std::vector{home});
}

TEST_F(IncomingWriterTest, AnswersAtBothAddressesUntilASecondHeartbeatConfirmsTheNewOne) {
  read_reliably();
  hear(1, 2);
  hear(1, 2, other_home);
  ask(0ms);
  EXPECT_EQ(answered_, (std::vector{home, other_home}));
  hear(1, 2, other_home);
  ask(0ms);
  EXPECT_EQ(answered_, std::vector{other_home});
}

TEST_F(IncomingWriterTest, AsksForExactlyThoseBytesOfASampleThatHaveNotCome) {
  for (std::uint64_t round = sft::test::test_rounds(50); round > 0; --round) {
    restart({});
    read_reliably();
    const std::vector<Bytes> datagrams = sent(1, 30'000, true);
    receive(datagrams.front());
    // The gaps in the body: the offset of the first byte of each gap, and the offset of its end.
    std::map<std::uint32_t, std::uint32_t> missing;
    for (std::size_t i = 1; i < datagrams.size(); ++i) {
      const Following part = std::get<Following>(decode(datagrams[i]));
      const auto end = part.offset + static_cast<std::uint32_t>(part.payload.size());
      if (random() % 2 == 0) {
        receive(datagrams[i]);
      } else if (!missing.empty() && missing.rbegin()->second == part.offset) {
        missing.rbegin()->second = end;
      } else {
        missing[part.offset] = end;
      }
    }
    hear(1, 2);
    std::map<std::uint32_t, std::uint32_t> asked;
    for (const Missing& part : ask(10ms)) {
      EXPECT_EQ(part.ordinal, 1U);
      asked[part.begin] = part.end;
    }
    ASSERT_EQ(asked, missing);
  }
}

TEST_F(IncomingWriterTest, GetsAllSamplesWhateverIsLostIfItIsSentWhatItAsksFor) {
  read_reliably();
  constexpr std::uint32_t samples = 20;
  std::map<std::uint32_t, std::size_t> bytes;
  const auto send = [&](std::uint32_t ordinal, BodyRange range) {
    for (const Bytes& datagram : sent(ordinal, bytes.at(ordinal), true, range)) {
      if (random() % 3 != 0) receive(datagram);
    }
  };
  for (std::uint32_t ordinal = 1; ordinal <= samples; ++ordinal) {
    bytes[ordinal] = random() % 10'000;
    send(ordinal, {});
  }
  for (int round = 0; taken_.size() < samples; ++round) {
    ASSERT_LT(round, 1000) << "only " << taken_.size() << " samples came";
    hear(1, samples + 1);
    for (const Missing& part : ask(50ms))
      send(part.ordinal, {part.begin, part.begin == part.end ? UINT32_MAX : part.end});
  }
  for (const core::SampleHandle& sample : taken_) {
    const auto ordinal = static_cast<std::uint32_t>(sample->header().sequence);
    EXPECT_EQ(test::body_of(*sample), test::encoded_body(make_image(bytes[ordinal], ordinal), sample->mask));
  }
  Sequences sequences = taken();
  std::ranges::sort(sequences);
  EXPECT_TRUE(std::ranges::adjacent_find(sequences) == sequences.end()) << "a sample came twice";
}

/// Each request covers at most six samples. More than six samples are missing when each heartbeat arrives.
TEST_F(IncomingWriterTest, AsksForTheFirstMissingSampleWhateverElseIsMissing) {
  for (int apart_ms = 0; apart_ms < 250; apart_ms += 10) {
    restart({});
    read_reliably();
    hear(1, 51);
    for (int ms = 0; ms < apart_ms; ++ms) ask(1ms);
    for (int heartbeats = 0; heartbeats < 10; ++heartbeats) {
      hear(1, 101);
      bool asked_for_first = false;
      for (int ms = 0; ms < 1000; ++ms) {
        for (const Missing& part : ask(1ms)) asked_for_first |= part.ordinal == 1;
      }
      ASSERT_TRUE(asked_for_first) << apart_ms << " ms apart, after heartbeat " << heartbeats;
      EXPECT_EQ(writer_->next_answer(), IncomingWriter::Time::max()) << "nothing may be asked for now";
    }
  }
}

TEST_F(IncomingWriterTest, AsksForNothingThatWasSentWhileNobodyReadIt) {
  read_reliably();
  hear(1, 1);
  receive(sent(1, 100, true));
  const auto departed = writer_->close_window();
  ASSERT_TRUE(departed);
  writer_->open_window(departed);
  writer_->window()->set_readers({1});
  hear(1, 50);
  EXPECT_TRUE(ask(10ms).empty());
  receive(sent(51, 100, true));
  const std::vector<Missing> asked = ask(10ms);
  ASSERT_EQ(asked.size(), 1U);
  EXPECT_EQ(asked[0].ordinal, 50U);
}

TEST_F(IncomingWriterTest, PutsSamplesOfAGroupIntoTheChannelByTheOfferOfThatGroup) {
  read_reliably();
  hear(1, 1);
  FirstHeader by_group = header(1, false);
  by_group.flags = group_follows;
  by_group.group = {4, 0, 1};
  const Bytes datagram = cut(by_group, 100).front();
  EXPECT_FALSE(receive(*writer_, datagram).sample) << "nobody has offered the group";
  const GroupOffer offer{short_id, 4, 9, home.port, private_groups | 1, 1, 0};
  writer_->groups().hear(offer, home, now_);
  std::vector<std::uint32_t> groups;
  writer_->groups().addresses(groups);
  EXPECT_EQ(groups, std::vector{private_groups | 1});
  const Arrival arrival = receive(*writer_, datagram);
  EXPECT_TRUE(arrival.sample);
  EXPECT_TRUE(arrival.in_channel);
  EXPECT_EQ(writer_->window()->samples().next(), 2U);
}

TEST_F(IncomingWriterTest, GivesBackMemoryThatASampleReservedAndDoesNotUseWhereItIsShort) {
  restart({}, 500'000);
  read_reliably();
  hear(1, 1);
  for (std::uint32_t n = 11; n <= 20; ++n) receive(sent(n, 90'000, true).front());
  for (std::uint32_t n = 1; n <= 4; ++n) {
    ask(100ms);
    receive(sent(n, 100, true));  // a whole sample, which makes progress
    receive(sent(7, 90'000, true));
  }
  EXPECT_EQ(taken(), (Sequences{1, 2, 3, 7, 4})) << "the others made no progress for 300 ms";
  EXPECT_EQ(shared_->counters.incomplete, 1U);
}

TEST_F(IncomingWriterTest, TurnsToTheChannelOfSamplesAlsoWhereAnOfferNamesAnotherOneForTheirGroup) {
  read_reliably();
  hear(1, 1);
  const auto forge = [&](std::uint32_t channel) {
    FirstHeader first = header(1, true);
    first.channel.channel = channel;
    receive(cut(first, 100));
    EXPECT_TRUE(writer_->follows(channel));
  };
  forge(255);
  writer_->groups().hear({short_id, 4, 9, home.port, private_groups | 1, 255, 0}, home, now_);
  forge(1 << 20 | 1);
  for (std::uint32_t n = 100; n < 130; ++n) {
    FirstHeader by_group = header(n, false);
    by_group.flags = group_follows;
    by_group.group = {4, 0, n};
    now_ += 10ms;
    receive(cut(by_group, 100));
    receive(sent(n, 100, true));
  }
  EXPECT_TRUE(writer_->follows(1));
}

#ifndef SFT_TEST_SANITIZED  // the sanitizers have an allocator of their own
TEST(UnfinishedSampleTest, KeepsNoMemoryOfParkedPayloads) {
  const auto lent_bytes = [] { return mallinfo2().uordblks + mallinfo2().hblkhd; };
  const std::size_t before = lent_bytes();
  const std::vector<std::byte> payload(60'000);
  UnfinishedSample sample;
  for (std::uint32_t i = 0; i < 5; ++i) sample.park(i * 60'000, payload, {});
  EXPECT_GT(lent_bytes(), before + 300'000);
  sample.clear();
  EXPECT_LT(lent_bytes(), before + 100'000) << "the sample will be used again for another one";
}
#endif

}  // namespace
}  // namespace sft::udp
