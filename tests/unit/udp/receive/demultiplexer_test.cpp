// These tests check that each datagram is decoded once and passed to the component that handles its kind,
// even if the datagram is forged.
#include "udp_transport/receive/demultiplexer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "tests/support/parse_datagram.h"
#include "tests/support/test_seed.h"
#include "tests/unit/udp/datagrams.h"
#include "tests/unit/udp/mutations.h"

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

constexpr std::uint32_t heard_channel = 5;
constexpr std::uint32_t group_address = private_groups | 3;
const SocketAddress writers_node{core::IpAddress(0x0A630102), 7000};
const SocketAddress unknown_sender{core::IpAddress(0x0A630109), 7000};

constexpr std::array all_kinds{
    DatagramKind::first,  DatagramKind::following,   DatagramKind::heartbeat,    DatagramKind::ack,
    DatagramKind::packed, DatagramKind::group_offer, DatagramKind::group_report, DatagramKind::mark,
    DatagramKind::report, DatagramKind::whole,       DatagramKind::group_probe,  DatagramKind::single,
    DatagramKind::far};
std::string name_of(DatagramKind kind) { return "kind " + std::to_string(static_cast<int>(kind)); }

template <class Control>
Bytes encoded(const Control& control, std::size_t bytes) {
  Bytes datagram(bytes);
  encode(control, datagram.data());
  return datagram;
}

/// This process reads one writer, reliably. The tests check to which component each datagram is handed.
class DemultiplexerTest : public sft::test::RandomTest {
 protected:
  DemultiplexerTest() {
    Stream stream{lone_writer, &test::type_support<Image>(), 0, {fields<Image>("*")}, true};
    stream.node = {.known = true, .addresses = {{.ip = writers_node.ip, .port = writers_node.port}}};
    reassembly_.set_streams({&stream, 1});
    reassembly_.window(0)->set_readers({1});
    receive(datagram_of(DatagramKind::heartbeat));
    handed_ = {};
  }

  /// Returns an honest datagram of that kind. A datagram of kind `following` is the last part of the sample
  /// of which the datagram of kind `first` is the first part.
  static Bytes datagram_of(DatagramKind kind, std::uint32_t of_writer = short_id) {
    switch (kind) {
      case DatagramKind::first:
        return sample_of(of_writer).front();
      case DatagramKind::following:
        return sample_of(of_writer).back();
      case DatagramKind::far:
        return far_of(of_writer);
      case DatagramKind::packed:
        return packed_of(of_writer);
      case DatagramKind::whole:
        return sample_of(of_writer, 100, true).front();
      case DatagramKind::single:
        return sample_of(of_writer, 100, false).front();
      case DatagramKind::heartbeat:
        return encoded(Heartbeat{of_writer, heard_channel, 4000, 1, 2}, heartbeat_bytes);
      case DatagramKind::ack: {
        Ack ack{.writer = of_writer, .channel = heard_channel, .next = 3};
        ack.missing[ack.missing_count++] = {3, 10, 20};
        return encoded(ack, ack.bytes());
      }
      case DatagramKind::group_offer:
        return encoded(GroupOffer{of_writer, 1, 9, 4000, group_address, 0, 0}, group_offer_bytes);
      case DatagramKind::group_report:
        return encoded(GroupReport{of_writer, 1, 9, 12}, group_report_bytes);
      case DatagramKind::group_probe:
        return encoded(GroupProbe{of_writer, 1, 12}, group_probe_bytes);
      case DatagramKind::mark:
        return encoded(FlowMark{77, 4000, 1000, 0, 55}, mark_bytes);
      case DatagramKind::report:
        return encoded(FlowReport{77, 1000, 5000, 3, 2, 100, 55}, report_bytes);
    }
    return {};
  }

  /// Returns the length of the header in a datagram of a sample.
  static std::size_t header_bytes(const Bytes& datagram) {
    return static_cast<std::size_t>(parse(datagram)->payload.data() - datagram.data());
  }

  void receive(const Bytes& datagram, const SocketAddress& from = writers_node) {
    const Arrival arrival = demultiplexer_.accept(datagram, from, {now_, 1});
    handed_.samples += (arrival.sample ? 1 : 0) + arrival.packed.size();
    handed_.in_channel += arrival.in_channel ? 1 : 0;
  }

  struct Handed {
    std::size_t samples = 0;
    /// The number of datagrams after which reliable readers may be able to take a sample.
    std::size_t in_channel = 0;
    std::vector<Answer> answers{};
    std::vector<std::pair<SocketAddress, FlowReport>> reports{};
    std::vector<std::uint32_t> joined{};
    std::vector<std::vector<std::uint32_t>> kept{};

    bool is_nothing() const { return samples + answers.size() + reports.size() + joined.size() == 0; }
  };
  std::uint64_t malformed() const { return reassembly_.counters().malformed; }
  std::uint64_t unknown() const { return reassembly_.counters().unknown; }

  Reassembly::Time now_{1h};
  Handed handed_;
  Reassembly reassembly_{{}, core::BufferPool::make(std::size_t{16} << 20)};
  Demultiplexer demultiplexer_{
      {.hear_answer = [this](const Answer& answer, const SocketAddress&,
                             Demultiplexer::Time) { handed_.answers.push_back(answer); },
       .send_report = [this](const SocketAddress& to,
                             const FlowReport& report) { handed_.reports.emplace_back(to, report); },
       .keep_groups =
           [this](std::span<const std::uint32_t> groups) {
             handed_.kept.emplace_back(groups.begin(), groups.end());
           },
       .join_group = [this](std::uint32_t group, const SocketAddress&,
                            bool) { handed_.joined.push_back(group); }},
      reassembly_,
      std::size_t{1} << 20};

 private:
  /// Returns the datagrams of the first sample in the channel.
  static std::vector<Bytes> sample_of(std::uint32_t of_writer, std::size_t bytes = 2000,
                                      bool in_short = false) {
    const Bytes body = test::encoded_body(make_image(bytes), fields<Image>("*"));
    const Segment segment{body.data(), body.size()};
    FirstHeader first{};
    first.label = {of_writer, 1, 0};
    first.flags = channel_follows;
    first.total = static_cast<std::uint32_t>(body.size());
    first.mask = fields<Image>("*").hash();
    first.stamp_ns = 5;
    first.channel = {heard_channel, 0, 1, in_short};
    return test::cut({first, {}, {&segment, 1}}, 1472);
  }
  static Bytes far_of(std::uint32_t of_writer) {
    Bytes datagram = encoded(FollowingHeader{{of_writer, 1, near_variants_end}, 1000}, far_header_bytes);
    datagram.resize(far_header_bytes + 500);
    return datagram;
  }
  static Bytes packed_of(std::uint32_t of_writer) {
    const Bytes body = test::encoded_body(make_image(20), fields<Image>("*"));
    FirstHeader first{};
    first.label = {of_writer, 1, 0};
    first.mask = fields<Image>("*").hash();
    first.stamp_ns = 5;
    Bytes datagram(first.bytes());
    encode(PackedHeader{first, 2, static_cast<std::uint16_t>(body.size())}, datagram.data());
    for (int i = 0; i < 2; ++i) datagram.insert(datagram.end(), body.begin(), body.end());
    return datagram;
  }
};

TEST_F(DemultiplexerTest, BringsTheSamplesOfEachKindOfSampleDatagram) {
  receive(datagram_of(DatagramKind::packed));
  EXPECT_EQ(handed_.samples, 2U);
  receive(datagram_of(DatagramKind::whole));
  EXPECT_EQ(handed_.samples, 3U);
  EXPECT_EQ(handed_.in_channel, 1U);
}

TEST_F(DemultiplexerTest, CountsASharedDatagramOnceIfItsLengthDiffersFromThatOfItsBodies) {
  for (const int bytes : {-1, 1}) {
    Bytes datagram = datagram_of(DatagramKind::packed);
    datagram.resize(datagram.size() + static_cast<std::size_t>(bytes));
    const std::uint64_t before = malformed();
    receive(datagram);
    EXPECT_EQ(malformed(), before + 1);
  }
  EXPECT_EQ(handed_.samples, 0U);
  EXPECT_EQ(unknown(), 0U);
}

TEST_F(DemultiplexerTest, BringsASampleOnceItsFirstAndItsFollowingDatagramHaveCome) {
  receive(datagram_of(DatagramKind::first));
  EXPECT_EQ(handed_.samples, 0U);
  receive(datagram_of(DatagramKind::following));
  EXPECT_EQ(handed_.samples, 1U);
}

TEST_F(DemultiplexerTest, TellsReliableReadersOfAHeartbeat) {
  receive(datagram_of(DatagramKind::heartbeat));
  EXPECT_EQ(handed_.in_channel, 1U);
  EXPECT_TRUE(handed_.is_nothing());
}

TEST_F(DemultiplexerTest, HandsAnswersOverAsTheyWereSentWhoeverSendsThem) {
  receive(datagram_of(DatagramKind::ack), unknown_sender);
  receive(datagram_of(DatagramKind::report), unknown_sender);
  receive(datagram_of(DatagramKind::group_report), unknown_sender);
  ASSERT_EQ(handed_.answers.size(), 3U);
  const Ack& ack = std::get<Ack>(handed_.answers[0]);
  EXPECT_EQ(ack.next, 3U);
  ASSERT_EQ(ack.missing_count, 1U);
  EXPECT_EQ(ack.missing[0], (Missing{3, 10, 20}));
  EXPECT_EQ(std::get<FlowReport>(handed_.answers[1]), (FlowReport{77, 1000, 5000, 3, 2, 100, 55}));
  EXPECT_EQ(std::get<GroupReport>(handed_.answers[2]), (GroupReport{short_id, 1, 9, 12}));
  EXPECT_EQ(malformed() + unknown(), 0U);
}

TEST_F(DemultiplexerTest, AnswersAMarkAtTheAddressThatItsNodeAnnounced) {
  receive(datagram_of(DatagramKind::mark));
  ASSERT_EQ(handed_.reports.size(), 1U);
  const auto& [to, report] = handed_.reports[0];
  EXPECT_EQ(to, (SocketAddress{writers_node.ip, 4000}));
  EXPECT_EQ(report.flow, 77U);
  EXPECT_EQ(report.position, 1000U);
  EXPECT_EQ(report.sent_at_ns, 55);
}

TEST_F(DemultiplexerTest, CountsMarksOfStrangersAndDoesNotAnswerThem) {
  receive(datagram_of(DatagramKind::mark), unknown_sender);
  EXPECT_TRUE(handed_.is_nothing());
  EXPECT_EQ(demultiplexer_.unknown_marks(), 1U);
  EXPECT_EQ(demultiplexer_.senders(), 0U);
}

TEST_F(DemultiplexerTest, KnowsAnAddressByTheSamplesThatCameFromThere) {
  receive(datagram_of(DatagramKind::whole), unknown_sender);
  ASSERT_EQ(handed_.samples, 1U);
  receive(datagram_of(DatagramKind::mark), unknown_sender);
  ASSERT_EQ(handed_.reports.size(), 1U);
  EXPECT_EQ(handed_.reports[0].first, (SocketAddress{writers_node.ip, 4000}))
      << "reports go to the address that was announced all the same";
}

TEST_F(DemultiplexerTest, ReportsHowManyDatagramsOfSamplesAndHeartbeatsCame) {
  receive(datagram_of(DatagramKind::mark));  // The sender is known after this mark.
  for (const DatagramKind kind : all_kinds) {
    if (kind != DatagramKind::mark) receive(datagram_of(kind));
  }
  receive(Bytes(20));  // counts as a datagram of a sample, because it might be a damaged datagram of a sample
  for (const DatagramKind kind : all_kinds) {
    Bytes malformed = datagram_of(kind);
    malformed.resize(following_header_bytes);  // shorter than any kind of datagram
    receive(malformed);
  }
  receive(encoded(FlowMark{77, 4000, 3000, 100, 56}, mark_bytes));
  ASSERT_EQ(handed_.reports.size(), 2U);
  const std::uint32_t sound = 7, unreadable = 1, malformed_samples_and_heartbeat = 7;
  EXPECT_EQ(handed_.reports[1].second.came, sound + unreadable + malformed_samples_and_heartbeat);
}

TEST_F(DemultiplexerTest, ReportsTheLongestDatagramThatCameFromTheAddressFromAnyOfItsPorts) {
  const Bytes mark = datagram_of(DatagramKind::mark);
  receive(mark);
  const Bytes sample = datagram_of(DatagramKind::first);
  SocketAddress other_port = writers_node;
  other_port.port = 4321;
  receive(sample, other_port);
  receive(mark);
  ASSERT_EQ(handed_.reports.size(), 2U);
  EXPECT_EQ(handed_.reports[0].second.longest, 0U) << "nothing was known of the address";
  EXPECT_EQ(handed_.reports[1].second.longest, sample.size());
}

TEST_F(DemultiplexerTest, JoinsAGroupThatIsOfferedAndLeavesItWhenTheOfferIsTakenBack) {
  receive(datagram_of(DatagramKind::group_offer));
  EXPECT_EQ(handed_.joined, std::vector{group_address});
  ASSERT_EQ(handed_.kept.size(), 1U);
  EXPECT_EQ(handed_.kept[0], std::vector{group_address});
  receive(encoded(GroupOffer{short_id, 1, 9, 4000, 0, 0, 0}, group_offer_bytes));
  ASSERT_EQ(handed_.kept.size(), 2U);
  EXPECT_EQ(handed_.kept[1], std::vector<std::uint32_t>{});
  EXPECT_EQ(handed_.joined.size(), 1U);
}

TEST_F(DemultiplexerTest, CountsDatagramsOfWritersThatNobodyReads) {
  std::uint64_t expected = 0;
  for (const DatagramKind kind : all_kinds) {
    if (is_answer(kind) || kind == DatagramKind::mark) continue;
    receive(datagram_of(kind, short_id + 1));
    EXPECT_EQ(unknown(), ++expected) << name_of(kind);
  }
  EXPECT_TRUE(handed_.is_nothing());
  EXPECT_TRUE(handed_.kept.empty());
  EXPECT_EQ(handed_.in_channel, 0U);
  EXPECT_EQ(malformed(), 0U);
}

TEST_F(DemultiplexerTest, HandsNothingOfATruncatedDatagramToAnybody) {
  for (const DatagramKind kind : all_kinds) {
    const Bytes datagram = datagram_of(kind);
    for (std::size_t bytes = 0; bytes < datagram.size(); ++bytes) {
      const std::uint64_t before = malformed();
      receive(Bytes(datagram.begin(), datagram.begin() + static_cast<std::ptrdiff_t>(bytes)));
      ASSERT_TRUE(handed_.is_nothing()) << name_of(kind) << ", " << bytes << " bytes";
      // The end of a sample's payload may arrive in another datagram.
      const bool is_malformed = !is_of_sample(kind) || bytes < header_bytes(datagram);
      ASSERT_GE(malformed(), before + (is_malformed ? 1 : 0)) << name_of(kind) << ", " << bytes << " bytes";
    }
  }
}

TEST_F(DemultiplexerTest, CountsDatagramsOfOtherVersionsAndKindsAsMalformed) {
  std::uint64_t expected = 0;
  for (unsigned first_byte = 0; first_byte < 256; ++first_byte) {
    const unsigned version = first_byte >> 4, kind = first_byte & 0xf;
    if (version == wire_version && kind >= 1 && kind <= 13) continue;
    Bytes datagram = datagram_of(DatagramKind::whole);
    datagram[0] = static_cast<std::byte>(first_byte);
    receive(datagram);
    ASSERT_EQ(malformed(), ++expected) << "first byte " << first_byte;
  }
  receive(Bytes(datagram_bytes_max + 1, datagram_of(DatagramKind::first)[0]));
  EXPECT_EQ(malformed(), ++expected);
  EXPECT_TRUE(handed_.is_nothing());
}

TEST_F(DemultiplexerTest, HandsForgedDatagramsToNobodyThatTheirKindIsNotFor) {
  std::vector<Bytes> honest;
  for (const DatagramKind kind : all_kinds) honest.push_back(datagram_of(kind));
  for (std::uint64_t round = sft::test::test_rounds(20'000); round > 0; --round) {
    Bytes forged = honest[random() % honest.size()];
    test::mutate(forged, random);
    handed_ = {};
    const std::uint64_t malformed_before = malformed();
    receive(forged);
    const auto kind = kind_of(forged);
    const bool is_sound_answer = kind && is_answer(*kind) && malformed() == malformed_before;
    EXPECT_EQ(handed_.answers.size(), is_sound_answer ? 1U : 0U);
    EXPECT_TRUE(handed_.reports.empty() || kind == DatagramKind::mark);
    EXPECT_TRUE(handed_.joined.empty() || kind == DatagramKind::group_offer);
    EXPECT_TRUE(handed_.samples == 0 || (kind && is_of_sample(*kind)));
    ASSERT_FALSE(HasFailure()) << "a forged datagram of " << forged.size() << " bytes";
    if (round % 64 == 0) reassembly_.expire(now_ += 100ms);
  }
}

}  // namespace
}  // namespace sft::udp
