#include "udp_transport/receive/reassembly.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "tests/support/parse_datagram.h"
#include "tests/support/test_seed.h"
#include "tests/unit/udp/arrivals.h"
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
using test::Wide;

/// Images of one writer. sent() makes their datagrams, receive() delivers datagrams, and taken() returns the
/// samples.
class ReassemblyTest : public testing::Test {
 protected:
  ReassemblyTest() { restart({}); }

  void restart(const ReassemblyLimits& limits, std::size_t pool_bytes = std::size_t{64} << 20) {
    pool_ = core::BufferPool::make(pool_bytes);
    reassembly_ = std::make_unique<Reassembly>(limits, pool_);
    read_under({"*", "stamp", "data"});
  }

  void read_under(std::initializer_list<const char*> masks, std::size_t max_sample_bytes = 0) {
    Stream stream{lone_writer, &test::type_support<Image>(), max_sample_bytes, {}};
    for (const char* mask : masks) stream.selections.push_back(fields<Image>(mask));
    reassembly_->set_streams({&stream, 1});
  }

  std::vector<Bytes> sent(std::uint32_t sequence, const Image& image, const char* mask = "*",
                          std::uint16_t variant = 0) const {
    return test::datagrams_of(image, fields<Image>(mask),
                              {static_cast<std::uint32_t>(lone_writer), sequence, variant});
  }

  void receive(const Bytes& datagram) {
    Arrival arrival = test::accept(*reassembly_, datagram, {now_, 77});
    if (arrival.sample) taken_.push_back(std::move(arrival.sample));
  }
  void receive(const std::vector<Bytes>& datagrams) {
    for (const Bytes& datagram : datagrams) receive(datagram);
  }
  void receive_without_first(const std::vector<Bytes>& datagrams) {
    receive(std::vector<Bytes>(datagrams.begin() + 1, datagrams.end()));
  }

  void pass(std::chrono::milliseconds time) {
    now_ += time;
    reassembly_->expire(now_);
  }

  std::vector<std::uint64_t> taken() const {
    std::vector<std::uint64_t> sequences;
    for (const core::SampleHandle& sample : taken_) sequences.push_back(sample->header().sequence);
    return sequences;
  }
  const core::Transport::Counters& counted() const { return reassembly_->counters(); }

  using Sequences = std::vector<std::uint64_t>;

  Reassembly::Time now_ = Reassembly::Time{} + 1h;
  std::shared_ptr<core::BufferPool> pool_;
  std::unique_ptr<Reassembly> reassembly_;
  std::vector<core::SampleHandle> taken_;
};

TEST_F(ReassemblyTest, GivesASmallSampleAtOnceAsItWasSent) {
  const Image image = make_image(64);
  receive(sent(9, image, "stamp, data"));
  EXPECT_EQ(taken(), Sequences{}) << "nobody reads under this mask";

  receive(sent(9, image, "*", 1));
  ASSERT_EQ(taken(), Sequences{9});
  const core::SampleBuffer& sample = *taken_[0];
  EXPECT_EQ(test::body_of(sample), test::encoded_body(image, fields<Image>("*")));
  EXPECT_EQ(sample.mask, fields<Image>("*"));
  EXPECT_EQ(sample.receive_stamp_ns, 77);
  EXPECT_EQ(sample.header().magic, sample_magic);
  EXPECT_EQ(sample.header().writer, lone_writer);
  EXPECT_EQ(sample.header().source_stamp_ns, 5);
  EXPECT_EQ(sample.header().type_hash, test::type_support<Image>().hash());
  EXPECT_EQ(sample.header().index_slots, 6U);
  const std::byte* body = sample.data + sample.header().body_offset;
  EXPECT_EQ(reinterpret_cast<std::uintptr_t>(body) % 8, 0U);
  EXPECT_EQ(std::memcmp(body - 4, encapsulation_cdr_le.data(), 4), 0);
  EXPECT_EQ(sample.index()[3], 20U) << "height: after the stamp and the name";
}

TEST_F(ReassemblyTest, PutsALargeSampleTogether) {
  const Image image = make_image(1'000'000);
  receive(sent(1, image, "data"));
  ASSERT_EQ(taken(), Sequences{1});
  EXPECT_EQ(test::body_of(*taken_[0]), test::encoded_body(image, fields<Image>("data")));
  EXPECT_FALSE(reassembly_->next_expiry()) << "nothing is left over";
}

TEST_F(ReassemblyTest, TakesTheEmptyMask) {
  read_under({""});
  receive(sent(3, make_image(100), ""));
  ASSERT_EQ(taken(), Sequences{3});
  EXPECT_EQ(taken_[0]->header().body_bytes, 0U);
}

TEST_F(ReassemblyTest, DoesNotMindTheOrder) {
  const Image image = make_image(20'000);
  auto datagrams = sent(1, image);
  std::reverse(datagrams.begin(), datagrams.end());
  receive(datagrams);
  ASSERT_EQ(taken(), Sequences{1});
  EXPECT_EQ(test::body_of(*taken_[0]), test::encoded_body(image, fields<Image>("*")));
}

TEST_F(ReassemblyTest, MakesOneSampleOfRepeatedDatagrams) {
  const auto datagrams = sent(1, make_image(20'000));
  for (const Bytes& datagram : datagrams) receive(std::vector<Bytes>{datagram, datagram});
  receive(datagrams);
  EXPECT_EQ(taken(), Sequences{1});
  EXPECT_FALSE(reassembly_->next_expiry()) << "what came afterwards did not begin the sample again";
}

TEST_F(ReassemblyTest, MakesOneSampleOfARepeatedSmallOne) {
  const auto datagrams = sent(1, make_image(20));
  receive(datagrams);
  receive(datagrams);
  EXPECT_EQ(taken(), Sequences{1});
}

TEST_F(ReassemblyTest, KeepsTheVariantsOfASampleApart) {
  const Image image = make_image(10'000);
  const auto all = sent(1, image, "*", 0);
  const auto data = sent(1, image, "data", 1);
  for (std::size_t i = 0; i < std::max(all.size(), data.size()); ++i) {
    if (i < all.size()) receive(all[i]);
    if (i < data.size()) receive(data[i]);
  }
  ASSERT_EQ(taken(), (Sequences{1, 1}));
  EXPECT_NE(taken_[0]->mask, taken_[1]->mask);
}

TEST_F(ReassemblyTest, GivesUpASampleThatMakesNoProgress) {
  auto datagrams = sent(1, make_image(20'000));
  datagrams.pop_back();
  receive(datagrams);
  pass(499ms);
  EXPECT_EQ(counted().incomplete, 0U);
  pass(2ms);
  EXPECT_EQ(counted().incomplete, 1U);
  EXPECT_FALSE(reassembly_->next_expiry());
}

TEST_F(ReassemblyTest, WaitsForASampleThatMakesProgress) {
  for (const Bytes& datagram : sent(1, make_image(20'000))) {
    receive(datagram);
    pass(400ms);
  }
  EXPECT_EQ(taken(), Sequences{1});
  EXPECT_EQ(counted().incomplete, 0U);
}

TEST_F(ReassemblyTest, TakesNoRepeatedDatagramForProgress) {
  const auto datagrams = sent(1, make_image(20'000));
  receive(datagrams[0]);
  receive(datagrams[1]);
  pass(400ms);
  receive(datagrams[1]);
  pass(101ms);
  EXPECT_EQ(counted().incomplete, 1U);
}

TEST_F(ReassemblyTest, IgnoresWhatStillComesOfASampleThatItGaveUp) {
  auto datagrams = sent(1, make_image(20'000));
  const Bytes last = datagrams.back();
  datagrams.pop_back();
  receive(datagrams);
  pass(1s);
  receive(last);
  EXPECT_FALSE(reassembly_->next_expiry());
  EXPECT_EQ(counted().incomplete, 1U);
}

TEST_F(ReassemblyTest, DropsTheOldestOfAVariantWhenTooManyHaveBegun) {
  std::map<std::uint32_t, Bytes> last;
  for (std::uint32_t sequence = 1; sequence <= 5; ++sequence) {
    auto datagrams = sent(sequence, make_image(5'000));
    last[sequence] = datagrams.back();
    datagrams.pop_back();
    receive(datagrams);
  }
  EXPECT_EQ(counted().incomplete, 1U);
  for (const auto& [sequence, datagram] : last) receive(datagram);
  EXPECT_EQ(taken(), (Sequences{2, 3, 4, 5}));
}

TEST_F(ReassemblyTest, LimitsWhatHasBegunOverAllVariantsOfAWriter) {
  for (std::uint16_t variant = 0; variant < 1000; ++variant)
    receive(sent(1, make_image(5'000), "*", variant)[0]);
  EXPECT_EQ(counted().incomplete, 1000U - ReassemblyLimits{}.unfinished_per_writer);
}

TEST_F(ReassemblyTest, LimitsTheMemoryOfWhatHasBegun) {
  restart({.unfinished_bytes = 100'000});
  for (std::uint32_t sequence = 1; sequence <= 3; ++sequence) receive(sent(sequence, make_image(40'000))[0]);
  EXPECT_EQ(counted().incomplete, 1U);
}

TEST_F(ReassemblyTest, MakesRoomWithTheOldestOfTheSameVariantFirst) {
  restart({.unfinished_bytes = 130'000});
  const Image image = make_image(40'000);
  const auto other = sent(11, image, "*", 7), older = sent(1, image), newer = sent(2, image);
  for (const auto* datagrams : {&other, &older, &newer}) receive(datagrams->front());
  receive(sent(3, image));
  for (const auto* datagrams : {&other, &older, &newer}) receive_without_first(*datagrams);
  EXPECT_EQ(taken(), (Sequences{3, 11, 2})) << "the first one of the same variant went";
  EXPECT_EQ(counted().incomplete, 1U);
  ASSERT_EQ(taken_.size(), 3U);
  restart({.unfinished_bytes = 130'000});
  taken_.clear();
  for (const auto* datagrams : {&other, &older, &newer}) receive(datagrams->front());
  receive(sent(3, image, "*", 9));
  for (const auto* datagrams : {&other, &older, &newer}) receive_without_first(*datagrams);
  EXPECT_EQ(taken(), (Sequences{3, 1, 2})) << "else the oldest of all goes";
}

TEST_F(ReassemblyTest, MakesRoomInAFullPoolByDroppingTheWritersOldest) {
  restart({}, 400'000);
  for (std::uint32_t sequence = 1; sequence <= 2; ++sequence) receive(sent(sequence, make_image(100'000))[0]);
  EXPECT_EQ(counted().incomplete, 0U);
  receive(sent(3, make_image(100'000)));
  EXPECT_EQ(taken(), Sequences{3});
  EXPECT_EQ(counted().incomplete, 1U);
}

TEST_F(ReassemblyTest, LeavesMemoryToWhatIsPublishedHere) {
  restart({}, 1'000'000);
  for (std::uint32_t sequence = 1; sequence <= 100; ++sequence) receive(sent(sequence, make_image(50'000)));
  EXPECT_LT(taken().size(), 100U);
  EXPECT_TRUE(pool_->take(100'000));
}

TEST_F(ReassemblyTest, DropsASampleThatThePoolCannotHold) {
  restart({}, 10'000);
  receive(sent(1, make_image(100'000)));
  EXPECT_EQ(taken(), Sequences{});
  EXPECT_EQ(counted().over_limit, 1U) << "counted once, not with each datagram";
}

TEST_F(ReassemblyTest, RefusesATotalBeyondWhatTheWriterAnnounced) {
  read_under({"*"}, 1'000);
  receive(sent(1, make_image(2'000)));
  receive(sent(2, make_image(500)));
  EXPECT_EQ(taken(), Sequences{2});
  EXPECT_EQ(counted().over_limit, 1U);
}

TEST_F(ReassemblyTest, RefusesATotalBeyondItsOwnLimit) {
  restart({.sample_bytes = 1'000});
  receive(sent(1, make_image(2'000)));
  EXPECT_EQ(taken(), Sequences{});
  EXPECT_EQ(counted().over_limit, 1U);
}

TEST_F(ReassemblyTest, LimitsWhatIsParkedBeforeTheFirstDatagram) {
  restart({.parked_bytes = 10'000});
  receive_without_first(sent(1, make_image(100'000)));
  EXPECT_EQ(counted().over_limit, 1U);
  receive(sent(2, make_image(5'000)));
  EXPECT_EQ(taken(), Sequences{2});
}

TEST_F(ReassemblyTest, FreesWhatWasParkedWithItsSample) {
  restart({.parked_bytes = 10'000});
  for (std::uint32_t sequence = 1; sequence <= 50; ++sequence) {
    receive_without_first(sent(sequence, make_image(6'000)));
    pass(1s);
  }
  EXPECT_EQ(counted().incomplete, 50U);
  EXPECT_EQ(counted().over_limit, 0U);
}

// For each way of ending, more samples end than memory and parked bytes could hold at the same time.
TEST_F(ReassemblyTest, GivesBackAllThatASampleHasTakenHoweverItEnds) {
  constexpr std::size_t bytes = 6'000;
  std::uint32_t sequence = 0;
  std::vector<Bytes> datagrams;  // the datagrams of the present sample
  const auto begin_without_first = [&] { receive_without_first(datagrams); };
  const auto begin_with_first = [&] { receive(datagrams.front()); };
  const std::map<std::string, std::function<void()>> endings{
      {"it becomes whole", [&] { receive(datagrams); }},
      {"newer ones push it out", [] {}},
      {"it makes no progress", [&] { pass(1s); }},
      {"its first datagram has a smaller length", [&] { receive(sent(sequence, make_image(100))); }},
      {"its first datagram has a mask that no reader asks for", [&] { receive(sent(sequence, {}, "name")); }},
      {"its writer has no reader any more",
       [&] {
         reassembly_->set_streams({});
         read_under({"*"});
       }},
  };
  for (const auto& [why, end] : endings) {
    for (const bool first_comes_first : {false, true}) {
      SCOPED_TRACE(why + (first_comes_first ? ", behind its first datagram" : ", before its first datagram"));
      restart({.unfinished_bytes = 10 * bytes, .parked_bytes = 10 * bytes}, 30 * bytes);
      for (int round = 0; round < 100; ++round) {
        datagrams = sent(++sequence, make_image(bytes));
        first_comes_first ? begin_with_first() : begin_without_first();
        end();
        taken_.clear();
      }
      EXPECT_EQ(counted().over_limit, 0U);
      const auto one = sent(++sequence, make_image(4 * bytes));
      const auto other = sent(++sequence, make_image(4 * bytes));
      for (const auto* both : {&one, &other}) receive(both->front());
      for (const auto* both : {&one, &other}) receive_without_first(*both);
      EXPECT_EQ(taken(), (Sequences{sequence - 1, sequence})) << "there is room for as many as at first";
      taken_.clear();
      reassembly_->set_streams({});
      read_under({"*"});
      receive_without_first(sent(++sequence, make_image(9 * bytes)));
      EXPECT_EQ(counted().over_limit, 0U) << "as many bytes as at first can be parked";
    }
  }
}

TEST_F(ReassemblyTest, DropsASampleWithTooManyGaps) {
  restart({.gaps = 10});
  const auto datagrams = sent(1, make_image(100'000));
  receive(datagrams[0]);
  for (std::size_t i = 2; i < datagrams.size(); i += 2) receive(datagrams[i]);
  EXPECT_EQ(counted().over_limit, 1U);
}

TEST_F(ReassemblyTest, CountsWritersThatNobodyReads) {
  receive(
      test::datagrams_of(make_image(10), fields<Image>("*"), {.writer = 4711, .sequence = 1, .variant = 0}));
  EXPECT_EQ(counted().unknown, 1U);
}

TEST_F(ReassemblyTest, TellsWritersWithOneShortIdApartByTheAddressesOfTheirNodes) {
  const core::IpAddress honest_ip(0x0a000001), forger_ip(0x0a000002), unknown_ip(0x0a000003);
  const core::EndpointId twin = lone_writer + (core::EndpointId{1} << 32);
  const auto stream = [](core::EndpointId id, const core::IpAddress& ip) {
    Stream made{id, &test::type_support<Image>(), 0, {fields<Image>("*")}};
    made.node = {.known = true, .addresses = {{.ip = ip, .port = 7000}}};
    return made;
  };
  const auto writer_of = [&](std::uint32_t sequence, const core::IpAddress& from) -> core::EndpointId {
    for (const Bytes& datagram : sent(sequence, make_image(64))) {
      const Arrival arrival = test::accept(*reassembly_, datagram, {now_, 77}, {from, 0});
      if (arrival.sample) return arrival.sample->header().writer;
    }
    return 0;
  };
  const std::vector<Stream> both{stream(twin, forger_ip), stream(lone_writer, honest_ip)};
  reassembly_->set_streams(both);
  EXPECT_EQ(writer_of(1, honest_ip), lone_writer);
  EXPECT_EQ(writer_of(1, forger_ip), twin);
  EXPECT_EQ(writer_of(2, honest_ip), lone_writer);
  EXPECT_EQ(writer_of(2, unknown_ip), twin) << "the first one, if nobody announced the address";
  reassembly_->set_streams(std::span(both).last(1));
  EXPECT_EQ(writer_of(3, unknown_ip), lone_writer) << "who has no twin may come from anywhere";
}

TEST_F(ReassemblyTest, TellsWritersWithOneShortIdAndOneAddressApartByWhatTheyAnnouncedOfTheirSamples) {
  const core::IpAddress ip(0x0a000001);
  std::vector<Stream> streams;
  for (std::uint64_t i = 0; i < 8; ++i) {  // The honest writer is the last one.
    streams.push_back({lone_writer + ((7 - i) << 32),
                       &test::type_support<Image>(),
                       i == 7 ? 0 : std::size_t{1},
                       {fields<Image>("*")}});
    streams.back().node = {.known = true, .addresses = {{.ip = ip, .port = 7000}}};
  }
  reassembly_->set_streams(streams);
  const auto writer_of = [&](std::uint32_t sequence, std::size_t bytes) -> core::EndpointId {
    for (const Bytes& datagram : sent(sequence, make_image(bytes))) {
      const Arrival arrival = test::accept(*reassembly_, datagram, {now_, 77}, {ip, 0});
      if (arrival.sample) return arrival.sample->header().writer;
    }
    return 0;
  };
  EXPECT_EQ(writer_of(1, 64), lone_writer);
  EXPECT_EQ(writer_of(2, 20'000), lone_writer);
  for (std::size_t i = 0; i < 7; ++i) {
    streams[i].max_sample_bytes = 0;
    streams[i].alive = false;
  }
  reassembly_->set_streams(streams);
  EXPECT_EQ(writer_of(3, 64), lone_writer) << "those that live come first";
}

TEST_F(ReassemblyTest, TakesNothingOnceMoreOfAWriterThatDoesNotAnswer) {
  Stream stream{lone_writer, &test::type_support<Image>(), 0, {fields<Image>("*")}};
  reassembly_->set_streams({&stream, 1});
  const auto takes = [&](std::uint32_t sequence) {
    bool came = false;
    for (const Bytes& datagram : sent(sequence, make_image(64)))
      came = test::accept(*reassembly_, datagram, {now_, 77}).sample || came;
    return came;
  };
  for (std::uint32_t sequence = 1; sequence <= 300; ++sequence) ASSERT_TRUE(takes(sequence));
  stream.alive = false;
  reassembly_->set_streams({&stream, 1});
  for (std::uint32_t sequence = 1; sequence < 300; ++sequence) ASSERT_FALSE(takes(sequence));
  EXPECT_TRUE(takes(301)) << "maybe only its signs of life get lost";
}

TEST_F(ReassemblyTest, CountsBytesThatAreNoDatagram) {
  receive(Bytes(5));
  receive(Bytes(100));
  EXPECT_EQ(counted().malformed, 2U);
}

TEST_F(ReassemblyTest, RefusesABodyThatIsNotOfItsType) {
  auto datagrams = sent(1, make_image(10));
  datagrams[0][parse(datagrams[0])->first.bytes_in_single() + 11] =
      std::byte{0xff};  // a wrong length of the name
  receive(datagrams);
  EXPECT_EQ(taken(), Sequences{});
  EXPECT_EQ(counted().malformed, 1U);
}

TEST_F(ReassemblyTest, RefusesPayloadBeyondTheTotal) {
  const auto datagrams = sent(1, make_image(3'000));
  receive(datagrams[0]);
  Bytes beyond = datagrams[1];
  encode(FollowingHeader{.label = {static_cast<std::uint32_t>(lone_writer), 1, 0}, .offset = 3'000},
         beyond.data());
  receive(beyond);
  EXPECT_EQ(counted().malformed, 1U);
  receive(datagrams);
  EXPECT_EQ(taken(), Sequences{1}) << "one bad datagram does not spoil the sample";
}

TEST_F(ReassemblyTest, RefusesASequenceOfZero) {
  receive(sent(0, make_image(10)));
  EXPECT_EQ(counted().malformed, 1U);
}

TEST_F(ReassemblyTest, CountsASampleWithAnImplausibleNumberAsMalformed) {
  receive(sent(100, make_image(10)));
  receive(sent(1'000'000'000, make_image(10)));
  receive(sent(101, make_image(10)));
  EXPECT_EQ(taken(), (Sequences{100, 101}));
  EXPECT_EQ(counted().malformed, 1U);
}

TEST_F(ReassemblyTest, WidensSequencesBeyond32Bits) {
  for (std::uint64_t sequence = 0x7000'0000; sequence < 0x3'0000'0000; sequence += 0x4000'0001) {
    receive(sent(static_cast<std::uint32_t>(sequence - 1), make_image(10)));
    pass(250ms);
    receive(sent(static_cast<std::uint32_t>(sequence), make_image(10)));
    EXPECT_EQ(taken_.back()->header().sequence, sequence) << "the one before it confirms it";
  }
}

TEST_F(ReassemblyTest, KeepsWhatHasBegunWhenOtherMasksAreWanted) {
  const auto datagrams = sent(1, make_image(5'000), "data");
  receive(datagrams[0]);
  read_under({"data", "height"});
  receive_without_first(datagrams);
  EXPECT_EQ(taken(), Sequences{1});
}

TEST_F(ReassemblyTest, ForgetsAWriterThatNobodyReadsAnyMore) {
  const auto datagrams = sent(1, make_image(5'000));
  receive(datagrams[0]);
  reassembly_->set_streams({});
  EXPECT_FALSE(reassembly_->next_expiry());
  receive_without_first(datagrams);
  EXPECT_EQ(taken(), Sequences{});
}

TEST_F(ReassemblyTest, TellsMasksOfMoreThan64LeavesApart) {
  const FieldMask both = fields<Wide>("first, seventh");
  Stream stream{lone_writer, &test::type_support<Wide>(), 0, {both}};
  reassembly_->set_streams({&stream, 1});
  Wide wide;
  wide.first.a = {1, 2, 3};
  wide.seventh.j = 4.5;
  const SampleLabel label{static_cast<std::uint32_t>(lone_writer), 1, 0};
  receive(test::datagrams_of(wide, fields<Wide>("first"), label));
  EXPECT_EQ(taken(), Sequences{});
  receive(test::datagrams_of(wide, both, {label.writer, 2, 1}));
  ASSERT_EQ(taken(), Sequences{2});
  EXPECT_EQ(test::body_of(*taken_[0]), test::encoded_body(wide, both));
  EXPECT_EQ(taken_[0]->mask, both);
}

TEST_F(ReassemblyTest, KnowsALongMaskByItsHashAlone) {
  const FieldMask both = fields<Wide>("first, seventh");
  Stream stream{lone_writer, &test::type_support<Wide>(), 0, {both}};
  reassembly_->set_streams({&stream, 1});
  auto datagrams = test::datagrams_of(Wide{}, both, {static_cast<std::uint32_t>(lone_writer), 1, 0});
  datagrams[0][1] = std::byte{0};
  datagrams[0].erase(datagrams[0].begin() + first_header_bytes,
                     datagrams[0].begin() + first_header_bytes + 16);
  receive(datagrams);
  EXPECT_EQ(taken(), Sequences{1});
}

TEST_F(ReassemblyTest, RefusesMaskWordsThatAreNotThereOrNotNeeded) {
  auto datagrams = sent(1, make_image(2000));
  datagrams[0][1] = std::byte{mask_words_follow | narrow_mask};
  receive(datagrams[0]);
  EXPECT_EQ(counted().malformed, 1U);

  const FieldMask all = fields<Wide>("*");
  Stream stream{lone_writer, &test::type_support<Wide>(), 0, {all}};
  reassembly_->set_streams({&stream, 1});
  auto wide = test::datagrams_of(Wide{}, all, {static_cast<std::uint32_t>(lone_writer), 2, 0});
  wide[0].resize(first_header_bytes + 8);
  receive(wide[0]);
  EXPECT_EQ(counted().malformed, 2U);
}

TEST_F(ReassemblyTest, SurvivesLossRepetitionAndDisorder) {
  const std::uint64_t seed = sft::test::test_seed();
  SCOPED_TRACE(sft::test::how_to_repeat());
  std::mt19937 random(seed);
  std::map<std::uint64_t, Bytes> expected;
  std::vector<Bytes> wire;
  for (std::uint32_t sequence = 1; sequence <= 200; ++sequence) {
    const Image image = make_image(random() % 40'000, sequence);
    expected[sequence] = test::encoded_body(image, fields<Image>("*"));
    const bool loses = random() % 4 == 0;
    auto datagrams = sent(sequence, image);
    for (Bytes& datagram : datagrams) {
      // The last datagram always arrives, so that each loss is noticed.
      const bool last = &datagram == &datagrams.back();
      if (loses && !last && random() % 20 == 0) continue;
      if (random() % 10 == 0) wire.push_back(datagram);
      wire.push_back(std::move(datagram));
      const std::size_t reach = std::min<std::size_t>(wire.size(), 8);
      if (random() % 5 == 0) std::swap(wire.back(), wire[wire.size() - 1 - random() % reach]);
    }
  }
  receive(wire);
  for (const core::SampleHandle& sample : taken_) {
    const auto found = expected.find(sample->header().sequence);
    ASSERT_NE(found, expected.end()) << "a sample came twice, or from nowhere";
    ASSERT_EQ(test::body_of(*sample), found->second);
    expected.erase(found);
  }
  pass(1s);
  EXPECT_EQ(counted().incomplete + counted().over_limit, expected.size());
  EXPECT_GT(taken_.size(), 100U);
}

/// The sanitizers find reads and writes out of bounds. The test itself checks that memory stays limited.
TEST_F(ReassemblyTest, SurvivesHostileBytes) {
  const std::uint64_t seed = sft::test::test_seed();
  SCOPED_TRACE(sft::test::how_to_repeat());
  std::mt19937 random(seed);
  std::vector<Bytes> honest;
  for (std::uint32_t sequence = 1; sequence <= 8; ++sequence) {
    for (Bytes& datagram : sent(sequence, make_image(sequence * 900), "*"))
      honest.push_back(std::move(datagram));
  }
  for (int round = 0; round < 100'000; ++round) {
    Bytes datagram = honest[random() % honest.size()];
    const std::size_t at_sequence = kind_of(datagram) == DatagramKind::following ? 6 : 8;
    if (random() % 2 == 0)
      // The low byte of the sequence, so that the datagram belongs to an unfinished sample.
      datagram[at_sequence] = static_cast<std::byte>(round / 40);
    for (unsigned changes = random() % 4; changes > 0; --changes) {
      const std::size_t reach =
          random() % 2 == 0 ? std::min<std::size_t>(datagram.size(), 40) : datagram.size();
      datagram[random() % reach] = static_cast<std::byte>(random());
    }
    if (random() % 8 == 0) datagram.resize(1 + random() % datagram.size());
    receive(datagram);
    if (taken_.size() > 4) taken_.clear();
    if (round % 64 == 0) pass(std::chrono::milliseconds(random() % 600));
  }
  taken_.clear();
  pass(1s);
  EXPECT_FALSE(reassembly_->next_expiry());
  EXPECT_GT(counted().malformed, 0U);
}

}  // namespace
}  // namespace sft::udp
