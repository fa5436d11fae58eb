// These tests check samples in a channel that fit into one datagram. They are sent with short headers, and
// arrive in any order.
#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "tests/support/parse_datagram.h"
#include "tests/unit/udp/arrivals.h"
#include "tests/unit/udp/datagrams.h"
#include "udp_transport/receive/reassembly.h"
#include "udp_transport/reliable/resend_window.h"

namespace sft::udp {
namespace {

using namespace detail;

using namespace std::chrono_literals;
using test::Bytes;
using test::fields;
using test::Image;
using test::lone_writer;
using test::make_image;
using test::Wide;

constexpr std::size_t path = 1472;

FirstHeader in_channel(std::uint64_t ordinal, std::uint64_t sequence, std::uint16_t variant = 3) {
  return {.label = {static_cast<std::uint32_t>(lone_writer), static_cast<std::uint32_t>(sequence), variant},
          .flags = channel_follows,
          .mask = 0xff,
          .stamp_ns = 4,
          .channel = {.channel = 5,
                      .sequence_high = static_cast<std::uint32_t>(sequence >> 32),
                      .ordinal = ordinal,
                      .in_short = true}};
}

class WholeCutTest : public testing::Test {
 protected:
  std::vector<Bytes> cut(FirstHeader first, std::size_t body_bytes, std::size_t datagram_bytes = path) {
    body_.resize(body_bytes);
    const Segment segment{body_.data(), body_.size()};
    first.total = static_cast<std::uint32_t>(body_bytes);
    if (!words_.empty()) first.flags |= mask_words_follow;
    return test::cut({first, words_, {&segment, 1}}, datagram_bytes);
  }
  static DatagramKind kind(const Bytes& datagram) { return *kind_of(datagram); }

  Bytes body_;
  std::vector<std::uint64_t> words_;
};

TEST_F(WholeCutTest, Has26BytesOfHeader) {
  for (const std::size_t bytes : {std::size_t{0}, std::size_t{1}, std::size_t{1025}, path - 26}) {
    const auto datagrams = cut(in_channel(1, 1), bytes);
    ASSERT_EQ(datagrams.size(), 1U) << bytes;
    EXPECT_EQ(kind(datagrams[0]), DatagramKind::whole);
    EXPECT_EQ(datagrams[0].size(), bytes + 26);
  }
}

TEST_F(WholeCutTest, IsCutAsAFirstAndAFollowingOneWhereThePathIsTooNarrow) {
  const auto datagrams = cut(in_channel(1, 1), path - 25);
  ASSERT_EQ(datagrams.size(), 2U);
  EXPECT_EQ(kind(datagrams[0]), DatagramKind::first);
  EXPECT_EQ(kind(datagrams[1]), DatagramKind::following);
  EXPECT_EQ(parse(datagrams[0])->label(), parse(datagrams[1])->label());
  EXPECT_EQ(kind(cut(in_channel(1, 1), path - 25, path + 1)[0]), DatagramKind::whole);
}

TEST_F(WholeCutTest, HasTheWordsOfALongMaskToo) {
  words_ = {0x0102030405060708, 0x42};
  const auto datagrams = cut(in_channel(1, 1), path - 26 - 16);
  ASSERT_EQ(datagrams.size(), 1U);
  EXPECT_EQ(kind(datagrams[0]), DatagramKind::whole);
  EXPECT_EQ(datagrams[0].size(), path);
  EXPECT_EQ(load_word(&datagrams[0][26]), 0x0102030405060708U);
  EXPECT_EQ(kind(cut(in_channel(1, 1), path - 26 - 15)[0]), DatagramKind::first) << "it does not fit";
}

TEST_F(WholeCutTest, IsNotUsedForWhatIsOfNoChannelOrHasMarks) {
  FirstHeader none = in_channel(1, 1);
  none.flags = 0;
  EXPECT_EQ(kind(cut(none, 100)[0]), DatagramKind::single);
  FirstHeader rated = in_channel(1, 1);
  rated.flags |= rate_follows;
  EXPECT_EQ(kind(cut(rated, 100)[0]), DatagramKind::first);
  FirstHeader grouped = in_channel(1, 1);
  grouped.flags = group_follows;
  EXPECT_EQ(kind(cut(grouped, 100)[0]), DatagramKind::first);
}

TEST_F(WholeCutTest, SaysAtLengthWhatIsBeyond32BitsAndReadsTheSame) {
  constexpr std::uint64_t turn = 0x1'0000'0000;
  for (std::uint64_t count = turn - 3; count < turn + 3; ++count) {
    const auto check = [&](const FirstHeader& sent, bool in_short) {
      const auto datagrams = cut(sent, 100);
      ASSERT_EQ(datagrams.size(), 1U);
      const auto d = parse(datagrams[0]);
      ASSERT_TRUE(d);
      EXPECT_EQ(d->kind, in_short ? DatagramKind::whole : DatagramKind::first) << count;
      EXPECT_EQ(d->first.channel.in_short, in_short) << count;
      ChannelMark read = d->first.channel;
      read.in_short = true;
      EXPECT_EQ(read, sent.channel);
      EXPECT_EQ(d->label(), sent.label);
      EXPECT_EQ(d->first.total, 100U);
    };
    check(in_channel(count, 9), count < turn);
    check(in_channel(9, count), count < turn);
  }
}

TEST_F(WholeCutTest, SaysOnlyTheLowBitsOfAChannelThatTheOtherEndKnows) {
  FirstHeader sent = in_channel(1, 1);
  sent.channel.channel = 0xfedc'ba98;
  const auto whole = parse(cut(sent, 100).at(0));
  ASSERT_TRUE(whole);
  EXPECT_EQ(whole->kind, DatagramKind::whole);
  EXPECT_EQ(whole->first.channel.channel, 0xfedc'ba98 % whole_channels_end);
  sent.channel.in_short = false;
  const auto first = parse(cut(sent, 100).at(0));
  ASSERT_TRUE(first);
  EXPECT_EQ(first->kind, DatagramKind::first);
  EXPECT_EQ(first->first.channel.channel, 0xfedc'ba98);
}

TEST_F(WholeCutTest, IsTheFormOfWhatAWindowKeepsUntilItsOrdinalsTurnOver) {
  const std::shared_ptr<JobPool> jobs = JobPool::make();
  ResendWindow window(1, 5, {}, 0xffff'fffe);
  std::vector<DatagramKind> kinds;
  for (std::uint64_t sequence = 1; sequence <= 3; ++sequence) {
    JobHandle job = jobs->take();
    job->mask = std::make_shared<WireMask>(WireMask{3, 0xff, {}});
    job->sequence = sequence;
    job->first.label = {1, static_cast<std::uint32_t>(sequence), 3};
    const auto piece = window.take(window.keep(job, job->first).ordinal);
    ASSERT_TRUE(piece);
    kinds.push_back(kind(test::cut(piece->body(), path).at(0)));
    window.hear({.writer = 1, .channel = 5, .next = 0xffff'fffe}, ResendWindow::Time{1h});
  }
  EXPECT_EQ(kinds, (std::vector{DatagramKind::first, DatagramKind::whole, DatagramKind::first}))
      << "before the first ack the other end may not know the channel";
}

/// Images of one writer, which arrive at a process through a channel.
class WholeTest : public testing::Test {
 protected:
  WholeTest() {
    read(true);
    reassembly_.window(0)->hear({.writer = 1, .channel = 5, .port = 7, .first = 1, .end = 1}, now_);
  }

  void read(bool reliable) {
    Stream stream{lone_writer, &test::type_support<Image>(), 0, {}, reliable};
    for (const char* mask : {"*", "stamp", "data"}) stream.selections.push_back(fields<Image>(mask));
    reassembly_.set_streams({&stream, 1});
    if (reliable) reassembly_.window(0)->set_readers({1});
  }

  static std::vector<Bytes> sent(std::uint64_t ordinal, std::uint64_t sequence, const Image& image,
                                 std::size_t datagram_bytes = path, const char* mask = "*",
                                 std::uint16_t variant = 3) {
    return sent(in_channel(ordinal, sequence, variant), image, fields<Image>(mask), datagram_bytes);
  }
  template <class T>
  static std::vector<Bytes> sent(FirstHeader first, const T& value, const FieldMask& mask,
                                 std::size_t datagram_bytes = path) {
    const Bytes body = test::encoded_body(value, mask);
    const Segment whole{body.data(), body.size()};
    std::vector<std::uint64_t> words;
    for (std::size_t i = 0; mask.words() > 1 && i < mask.words(); ++i) words.push_back(mask.word(i));
    if (!words.empty()) first.flags |= mask_words_follow;
    first.mask = mask.hash();
    first.total = static_cast<std::uint32_t>(body.size());
    return test::cut({first, words, {&whole, 1}}, datagram_bytes);
  }

  void receive(const Bytes& datagram) {
    Arrival arrival = test::accept(reassembly_, datagram, {now_, 77});
    if (arrival.sample) taken_.push_back(std::move(arrival.sample));
  }
  void receive(const std::vector<Bytes>& datagrams) {
    for (const Bytes& datagram : datagrams) receive(datagram);
  }

  using Sequences = std::vector<std::uint64_t>;
  /// Returns the sequences of the samples that the readers without ordered delivery got.
  Sequences taken() const {
    Sequences sequences;
    for (const core::SampleHandle& sample : taken_) sequences.push_back(sample->header().sequence);
    return sequences;
  }
  /// Returns the sequences of the samples that the reliable reader gets.
  Sequences in_order() {
    Sequences sequences;
    const auto any = [](const core::SampleBuffer&, std::uint64_t) { return true; };
    while (const core::SampleHandle sample = reassembly_.window(0)->next(1, any))
      sequences.push_back(sample->header().sequence);
    reassembly_.window(0)->release();
    return sequences;
  }
  /// Gives up all unfinished samples. Returns the number of samples that count as lost afterwards.
  std::uint64_t counted_as_lost() {
    now_ += 10s;
    reassembly_.expire(now_);
    const core::Transport::Counters& counters = reassembly_.counters();
    return counters.incomplete + counters.malformed + counters.over_limit;
  }

  Reassembly::Time now_ = Reassembly::Time{} + 1h;
  Reassembly reassembly_{{}, core::BufferPool::make(std::size_t{64} << 20)};
  std::vector<core::SampleHandle> taken_;
};

TEST_F(WholeTest, ComesAsItWasSent) {
  const Image image = make_image(1025);
  const auto datagrams = sent(1, 9, image);
  ASSERT_EQ(kind_of(datagrams.at(0)), DatagramKind::whole);
  receive(datagrams);
  ASSERT_EQ(taken(), Sequences{9});
  EXPECT_EQ(test::body_of(*taken_[0]), test::encoded_body(image, fields<Image>("*")));
  EXPECT_EQ(taken_[0]->header().source_stamp_ns, 4);
  EXPECT_EQ(taken_[0]->mask, fields<Image>("*"));
  EXPECT_EQ(in_order(), Sequences{9});
}

TEST_F(WholeTest, ComesAgainWhereItsChannelIsNotKnownAsYet) {
  Reassembly fresh{{}, core::BufferPool::make(std::size_t{64} << 20)};
  const Stream stream{lone_writer, &test::type_support<Image>(), 0, {fields<Image>("*")}, true};
  fresh.set_streams({&stream, 1});
  const auto datagrams = sent(1, 9, make_image(20));
  EXPECT_FALSE(test::accept(fresh, datagrams.at(0), {now_, 77}).sample);
  fresh.window(0)->hear({.writer = 1, .channel = 2048 + 5, .port = 7, .first = 1, .end = 2}, now_);
  EXPECT_TRUE(test::accept(fresh, datagrams.at(0), {now_, 77}).sample);
}

TEST_F(WholeTest, WaitsForItsTurnAndIsThereOnce) {
  receive(sent(2, 2, make_image(20)));
  receive(sent(2, 2, make_image(20)));
  EXPECT_EQ(in_order(), Sequences{});
  receive(sent(1, 1, make_image(20)));
  EXPECT_EQ(in_order(), (Sequences{1, 2}));
  EXPECT_EQ(taken(), (Sequences{2, 1}));
}

TEST_F(WholeTest, MayBeOfTheEmptyMask) {
  Stream stream{lone_writer, &test::type_support<Image>(), 0, {fields<Image>("")}, true};
  reassembly_.set_streams({&stream, 1});
  receive(sent(1, 3, make_image(100), path, ""));
  ASSERT_EQ(taken(), Sequences{3});
  EXPECT_EQ(taken_[0]->header().body_bytes, 0U);
}

TEST_F(WholeTest, IsKnownByItsOtherForm) {
  const Image image = make_image(1300);
  ASSERT_EQ(sent(1, 9, image, 800).size(), 2U) << "the path became narrower before it was asked for";
  receive(sent(1, 9, image));
  receive(sent(1, 9, image, 800));
  EXPECT_EQ(taken(), Sequences{9});
  receive(sent(2, 10, image, 800));
  receive(sent(2, 10, image));
  EXPECT_EQ(taken(), (Sequences{9, 10}));
  EXPECT_EQ(in_order(), (Sequences{9, 10}));
  EXPECT_EQ(counted_as_lost(), 0U);
}

TEST_F(WholeTest, TakesThePlaceOfWhatHadBegunWithoutADescription) {
  const Image image = make_image(1300);
  receive(sent(1, 9, image, 800).at(1));
  receive(sent(1, 9, image));
  EXPECT_EQ(taken(), Sequences{9});
  EXPECT_EQ(counted_as_lost(), 0U);
}

TEST_F(WholeTest, IsKnownByItsOtherFormWhereNobodyReadsReliablyAnyMore) {
  const Image image = make_image(1300);
  receive(sent(1, 9, image));
  read(false);
  receive(sent(1, 9, image, 800));
  receive(sent(1, 9, image));
  receive(sent(2, 10, image, 800));
  receive(sent(2, 10, image));
  EXPECT_EQ(taken(), (Sequences{9, 10}));
  EXPECT_EQ(counted_as_lost(), 0U);
}

TEST_F(WholeTest, IsNotMistakenForTheSameSampleUnderAnotherMask) {
  const Image image = make_image(900);
  for (const bool reliable : {true, false}) {
    read(reliable);
    taken_.clear();
    const std::uint64_t sequence = reliable ? 9 : 10, ordinal = reliable ? 1 : 3;
    receive(sent(ordinal, sequence, image, path, "*", 3));
    receive(sent(ordinal + 1, sequence, image, path, "stamp", 4));
    ASSERT_EQ(taken(), (Sequences{sequence, sequence})) << reliable;
    EXPECT_EQ(test::body_of(*taken_[1]), test::encoded_body(image, fields<Image>("stamp")));
  }
}

TEST_F(WholeTest, IsNotRepeatedByAGroupThatSentItToo) {
  const Image image = make_image(900);
  Bytes offer(group_offer_bytes);
  encode(GroupOffer{.writer = static_cast<std::uint32_t>(lone_writer),
                    .group = 1,
                    .port = 7,
                    .address = private_groups | 1,
                    .channel = 5,
                    .ahead = 10},
         offer.data());
  test::accept(reassembly_, offer, {});
  ASSERT_FALSE(reassembly_.groups().empty());
  const auto by_group = [&](std::uint64_t ordinal, std::uint64_t sequence) {
    FirstHeader first = in_channel(0, sequence);
    first.flags = group_follows | merged_masks;
    first.group = {.group = 1, .ordinal = ordinal};
    return sent(first, image, fields<Image>("*"));
  };
  const auto by_channel = [&](std::uint64_t ordinal, std::uint64_t sequence) {
    FirstHeader first = in_channel(ordinal, sequence);
    first.flags |= merged_masks;
    const auto datagrams = sent(first, image, fields<Image>("*"));
    EXPECT_EQ(kind_of(datagrams.at(0)), DatagramKind::whole);
    return datagrams;
  };
  receive(by_group(1, 21));
  receive(by_channel(11, 21));
  receive(by_channel(12, 22));
  receive(by_group(2, 22));
  EXPECT_EQ(taken(), (Sequences{21, 22}));
  ASSERT_TRUE(taken_[1]->merged);
  read(false);
  receive(by_channel(11, 21));
  receive(by_group(2, 22));
  EXPECT_EQ(taken(), (Sequences{21, 22})) << "when nobody reads reliably any more, either";
}

TEST_F(WholeTest, NamesAMaskOfMoreThan64Leaves) {
  const FieldMask both = fields<Wide>("first, seventh");
  Stream stream{lone_writer, &test::type_support<Wide>(), 0, {both}, true};
  reassembly_.set_streams({&stream, 1});
  Wide wide;
  wide.first.a = {1, 2, 3};
  wide.seventh.j = 4.5;
  receive(sent(in_channel(1, 1), wide, both));
  ASSERT_EQ(taken(), Sequences{1});
  EXPECT_EQ(test::body_of(*taken_[0]), test::encoded_body(wide, both));
  auto cut_short = sent(in_channel(2, 2), wide, both);
  ASSERT_EQ(kind_of(cut_short.at(0)), DatagramKind::whole);
  cut_short[0].resize(parse(cut_short[0])->first.bytes_in_short() + 15);
  receive(cut_short[0]);
  EXPECT_EQ(reassembly_.counters().malformed, 1U);
}

TEST_F(WholeTest, IsRefusedBeyondTheLimitBeforeMemoryIsTaken) {
  Stream stream{lone_writer, &test::type_support<Image>(), 100, {fields<Image>("*")}, true};
  reassembly_.set_streams({&stream, 1});
  receive(sent(1, 1, make_image(200)));
  EXPECT_EQ(taken(), Sequences{});
  EXPECT_EQ(reassembly_.counters().over_limit, 1U);
  receive(sent(2, 2, make_image(20)));
  EXPECT_EQ(taken(), Sequences{2});
}

TEST_F(WholeTest, IsRefusedWhereItsBytesAreNoBody) {
  auto datagrams = sent(1, 1, make_image(20));
  datagrams[0].pop_back();
  receive(datagrams);
  EXPECT_EQ(taken(), Sequences{});
  EXPECT_EQ(reassembly_.counters().malformed, 1U);
}

}  // namespace
}  // namespace sft::udp
