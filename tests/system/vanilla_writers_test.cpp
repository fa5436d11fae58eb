// Subscribers receive from writers of plain DDS, which know nothing of SFT, on this host and on another
// host.
#include <dds/dds.h>
#include <gmock/gmock.h>
#include <malloc.h>

#include <array>
#include <atomic>
#include <cstdint>
#include <deque>
#include <set>

#include "core/vanilla/raw_sample.h"
#include "tests/support/pace.h"
#include "tests/support/test_seed.h"
#include "tests/system/node_process.h"
#include "tests/system/vanilla_fixture.h"

namespace sft::test {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class VanillaHearingTest : public VanillaTest {
 protected:
  template <class S>
  static SubscriberStatus::Writer writer_of(const S& subscriber) {
    const SubscriberStatus status = subscriber.status();
    return status.writers.empty() ? SubscriberStatus::Writer{} : status.writers.front();
  }
  /// Returns the number of the next cloud; nothing if none comes.
  template <class S>
  static std::optional<std::uint32_t> next(S& subscriber) {
    if (!subscriber.wait(hang_timeout)) return {};
    const auto sample = subscriber.take();
    return sample->height();
  }
  /// Returns the numbers up to that one, which has to come.
  template <class S>
  static std::vector<std::uint32_t> until(S& subscriber, std::uint32_t last) {
    std::vector<std::uint32_t> numbers;
    while (numbers.empty() || numbers.back() != last) {
      const auto number = next(subscriber);
      if (!number) break;
      numbers.push_back(*number);
    }
    return numbers;
  }
  static std::vector<std::byte> encoded(const PointCloud2& message) {
    std::vector<std::byte> bytes{std::byte{0}, std::byte{1}, std::byte{0}, std::byte{0}};
    const std::vector<std::byte> body = body_of(message);
    bytes.insert(bytes.end(), body.begin(), body.end());
    return bytes;
  }
};

TEST_F(VanillaHearingTest, ATopicThatIsMisspeltIsNamedWithTheOneThatANodeOfDdsPublishes) {
  Node node = Node::open(options_with_log()).value();
  VanillaWriter writer(network_.host(1), {});
  const auto misspelt = node.subscriber<PointCloud2>("pionts").value();
  EXPECT_TRUE(warns_of("topic 'pionts': no publisher of it was seen; did you mean 'points', which node "));
}

/// A message as a big-endian writer encodes it, put together by hand.
class BigEndianBytes {
 public:
  explicit BigEndianBytes(const PointCloud2& c) {
    u32(static_cast<std::uint32_t>(c.header.stamp.sec));
    u32(c.header.stamp.nanosec);
    text(c.header.frame_id);
    u32(c.height);
    u32(c.width);
    u32(static_cast<std::uint32_t>(c.fields.size()));
    for (const auto& field : c.fields) {
      text(field.name);
      u32(field.offset);
      octet(field.datatype);
      u32(field.count);
    }
    octet(c.is_bigendian ? 1 : 0);
    u32(c.point_step);
    u32(c.row_step);
    u32(static_cast<std::uint32_t>(c.data.size()));
    for (const std::uint8_t byte : c.data) octet(byte);
    octet(c.is_dense ? 1 : 0);
  }
  const std::vector<std::byte>& bytes() const { return bytes_; }

 private:
  void octet(unsigned value) { bytes_.push_back(static_cast<std::byte>(value)); }
  void u32(std::uint32_t value) {
    while (bytes_.size() % 4 != 0) octet(0);
    for (const int shift : {24, 16, 8, 0}) octet(value >> shift & 255);
  }
  void text(const std::string& value) {
    u32(static_cast<std::uint32_t>(value.size() + 1));
    for (const char letter : value) octet(static_cast<unsigned char>(letter));
    octet(0);
  }
  std::vector<std::byte> bytes_{4};  ///< of the encapsulation, which is that of big-endian CDR
};

struct WriterCase {
  Way way = Way::udp;
  std::size_t host = 0;  ///< of the writer
  const char* reliability = "reliable";
};
std::string name_of_writer_case(const testing::TestParamInfo<WriterCase>& one) {
  return std::string(one.param.way == Way::shm ? "shm_" : "udp_") +
         (one.param.host == 0 ? "same_host_" : "other_host_") + one.param.reliability;
}
class VanillaWritersTest : public VanillaHearingTest, public testing::WithParamInterface<WriterCase> {};

TEST_P(VanillaWritersTest, AreHeardWithTheBytesAndTheNumberOfEachMessage) {
  Node node = open(GetParam().way);
  const Reliability wanted = GetParam().reliability == std::string("reliable") ? reliable : best_effort;
  auto sub = node.subscriber<PointCloud2>("points", {.reliability = wanted}).value();
  VanillaWriter writer(network_.host(GetParam().host), {.reliability = GetParam().reliability});
  ASSERT_TRUE(writer.matches(1) && hears(sub, 1));
  for (std::uint32_t i = 0; i < 5; ++i) {
    const std::size_t bytes = i < 4 ? 1000 + i : 300'000;  // with each padding
    const auto before = std::chrono::system_clock::now();
    writer.write_cloud(i, bytes);
    ASSERT_TRUE(sub.wait(hang_timeout));
    const auto sample = sub.take();
    EXPECT_TRUE(std::ranges::equal(sample.cdr().subspan(4), body_of(cloud(i, bytes))));
    EXPECT_EQ(sample.info().transport, TransportKind::dds);
    EXPECT_EQ(sample.info().sequence, i + 1);
    EXPECT_EQ(sample.info().writer, writer_of(sub).id);
    EXPECT_GE(sample.info().source_stamp, before);
    EXPECT_GE(sample.info().receive_stamp, sample.info().source_stamp);
    EXPECT_FALSE(sub.take()) << "once each";
  }
  EXPECT_EQ(sub.status().received, 5U);
  EXPECT_EQ(sub.status().lost, 0U);
  EXPECT_THAT(writer_of(sub).node, testing::StartsWith("DDS "));
}

INSTANTIATE_TEST_SUITE_P(Of, VanillaWritersTest,
                         testing::Values(WriterCase{Way::udp, 0, "reliable"},
                                         WriterCase{Way::udp, 1, "reliable"},
                                         WriterCase{Way::udp, 1, "best_effort"},
                                         WriterCase{Way::shm, 0, "reliable"},
                                         WriterCase{Way::shm, 1, "best_effort"}),
                         name_of_writer_case);

TEST_F(VanillaHearingTest, AWriterThatWasThereBeforeTheSubscriberIsHeard) {
  for (const std::size_t host : {0, 1}) {
    VanillaWriter writer(network_.host(host), {});
    Node node = open(Way::udp);
    auto sub = node.subscriber<PointCloud2>("points").value();
    ASSERT_TRUE(hears(sub, 1) && writer.matches(1));
    writer.write_cloud(7);
    EXPECT_EQ(next(sub), 7U);
  }
}

TEST_F(VanillaHearingTest, LatchedWritersDeliverWhatTheyRetainToEachSubscriberOnce) {
  VanillaWriter writer(network_.host(1), {.durability = "latched", .depth = 3});
  for (std::uint32_t i = 0; i < 5; ++i) writer.write_cloud(i);
  Node node = open(Way::udp);
  const SubscriberOptions latched{.durability = transient_local, .depth = 10};
  auto first = node.subscriber<PointCloud2>("points", latched).value();
  EXPECT_THAT(until(first, 4), ElementsAre(2, 3, 4));
  auto second = node.subscriber<PointCloud2>("points", latched).value();
  EXPECT_THAT(until(second, 4), ElementsAre(2, 3, 4));
  writer.write_cloud(5);
  EXPECT_EQ(next(first), 5U);
  EXPECT_EQ(next(second), 5U);
}

TEST_F(VanillaHearingTest, WritersOfEachQosOnOneTopicAreHeard) {
  Node node = open(Way::udp);
  auto sub = node.subscriber<PointCloud2>("points", {.depth = 100}).value();
  VanillaWriter latched(network_.host(1), {.durability = "latched"});
  ASSERT_TRUE(latched.matches(1) && hears(sub, 1));
  latched.write_cloud(1);
  EXPECT_EQ(next(sub), 1U);
  VanillaWriter lossy(network_.host(1), {.reliability = "best_effort"});
  ASSERT_TRUE(lossy.matches(1) && hears(sub, 2));
  lossy.write_cloud(2);
  EXPECT_EQ(next(sub), 2U);
  latched.write_cloud(3);
  EXPECT_EQ(next(sub), 3U);
}

TEST_F(VanillaHearingTest, AfterAWriterWasKilledTheNextOneIsHeardAndTheFirstOneIsForgotten) {
  Node node = open(Way::udp);
  auto sub = node.subscriber<PointCloud2>("points").value();
  VanillaWriter first(network_.host(1), {});
  ASSERT_TRUE(first.matches(1) && hears(sub, 1));
  first.write_cloud(1);
  EXPECT_EQ(next(sub), 1U);
  first.kill_now();
  EXPECT_TRUE(hears(sub, 0));
  VanillaWriter second(network_.host(1), {});
  ASSERT_TRUE(second.matches(1) && hears(sub, 1));
  second.write_cloud(2);
  EXPECT_EQ(next(sub), 2U);
}

TEST_F(VanillaHearingTest, AWriterThatWasStoppedGoesOn) {
  use_lease("100 s");
  Node node = open(Way::udp);
  auto sub = node.subscriber<PointCloud2>("points").value();
  VanillaWriter stopped(network_.host(1), {}), other(network_.host(1), {});
  ASSERT_TRUE(stopped.matches(1) && other.matches(1) && hears(sub, 2));
  stopped.hold_up();
  stopped.write_cloud(1);
  other.write_cloud(2);
  EXPECT_EQ(next(sub), 2U);
  stopped.let_go();
  EXPECT_EQ(next(sub), 1U);
}

TEST_F(VanillaHearingTest, AWriterThatLeavesAtOnceIsHeard) {
  Node node = open(Way::udp);
  auto sub = node.subscriber<PointCloud2>("points", {.reliability = reliable}).value();
  for (std::uint32_t i = 0; i < 10; ++i) {
    VanillaWriter writer(network_.host(1), {});
    ASSERT_TRUE(writer.matches(1));
    writer.write_cloud(i);
    writer.end();
    EXPECT_EQ(next(sub), i);
  }
}

TEST_F(VanillaHearingTest, ConditionsPartsAndRecordedFieldsAreThoseThatTheSubscriberAsksFor) {
  Node node = open(Way::udp);
  const SubscriberOptions all_kept{.reliability = reliable, .depth = 100};
  SubscriberOptions conditions = all_kept, every = all_kept, part = all_kept;
  conditions.selection = "@ height >= 6 and height < 9";
  every.selection = "@ every 4th";
  part.selection = "data[::2]";
  auto chosen = node.subscriber<PointCloud2>("points", conditions).value();
  auto fourth = node.subscriber<PointCloud2>("points", every).value();
  auto parts = node.subscriber<PointCloud2>("points", part).value();
  auto recorded = node.subscriber<PointCloud2, sft::recorded>("points", all_kept).value();
  VanillaWriter writer(network_.host(1), {});
  ASSERT_TRUE(writer.matches(4));
  for (std::uint32_t i = 1; i <= 12; ++i) writer.write_cloud(i);
  EXPECT_THAT(until(chosen, 8), ElementsAre(6, 7, 8));
  const std::uint32_t first = next(fourth).value_or(0);
  EXPECT_EQ(next(fourth), first + 4);
  EXPECT_EQ(next(fourth), first + 8);
  ASSERT_TRUE(parts.wait(hang_timeout) && recorded.wait(hang_timeout));
  const auto with_part = parts.take();
  const std::uint32_t rows = with_part->height(), columns = with_part->width();  // what is left of them
  EXPECT_EQ(columns, (with_part.info().sequence + 2) / 2);
  EXPECT_EQ(with_part->data().size(), std::size_t{10} * rows * columns);
  const auto with_fields = recorded.take();
  EXPECT_EQ(with_fields->height().value_or(0), with_fields.info().sequence);
}

TEST_F(VanillaHearingTest, WhatConditionsWithholdCountsAsWithheldAndNotAsLost) {
  Node node = open(Way::udp);
  SubscriberOptions options{.reliability = reliable, .depth = 100};
  options.selection = "@ height > 5";
  auto sub = node.subscriber<PointCloud2>("points", options).value();
  VanillaWriter writer(network_.host(1), {});
  ASSERT_TRUE(writer.matches(1));
  for (const std::uint32_t i : {9, 1, 2, 3, 10}) writer.write_cloud(i);
  EXPECT_THAT(until(sub, 10), ElementsAre(9, 10));
  EXPECT_EQ(sub.status().withheld, 3U);
  EXPECT_EQ(sub.status().lost, 0U);
}

TEST_F(VanillaHearingTest, CallbacksAndFileDescriptorsAreServed) {
  Node node = open(Way::udp);
  std::atomic<std::uint32_t> called{0};
  auto with_callback =
      node.subscriber<PointCloud2>("points", [&](const auto& sample) { called = sample->height(); }).value();
  auto pollable = node.subscriber<PointCloud2>("points", {.pollable = true}).value();
  VanillaWriter writer(network_.host(1), {});
  ASSERT_TRUE(writer.matches(2));
  writer.write_cloud(3);
  EXPECT_TRUE(eventually([&] { return called == 3; }));
  pollfd ready{pollable.file_descriptor(), POLLIN, 0};
  EXPECT_EQ(poll(&ready, 1, static_cast<int>(std::chrono::milliseconds(hang_timeout).count())), 1);
  EXPECT_EQ(next(pollable), 3U);
}

TEST_F(VanillaHearingTest, SixtyFourSubscribersGetEachMessage) {
  Node node = open(Way::udp);
  std::deque<Subscriber<PointCloud2>> subs;
  for (int i = 0; i < 64; ++i)
    subs.push_back(node.subscriber<PointCloud2>("points", {.reliability = reliable, .depth = 10}).value());
  VanillaWriter writer(network_.host(1), {});
  ASSERT_TRUE(writer.matches(64));
  for (std::uint32_t i = 1; i <= 5; ++i) writer.write_cloud(i, 100'000);
  for (auto& sub : subs) EXPECT_THAT(until(sub, 5), ElementsAre(1, 2, 3, 4, 5));
}

TEST_F(VanillaHearingTest, LargeMessagesComeWhole) {
  Node node = open(Way::udp);
  auto sub = node.subscriber<PointCloud2>("points", {.reliability = reliable}).value();
  VanillaWriter writer(network_.host(1), {});
  ASSERT_TRUE(writer.matches(1) && hears(sub, 1));
  for (std::uint32_t i = 1; i <= 3; ++i) {
    writer.write_cloud(i, 6'291'456);
    ASSERT_TRUE(sub.wait(hang_timeout));
    const auto sample = sub.take();
    EXPECT_TRUE(std::ranges::equal(sample.cdr().subspan(4), body_of(cloud(i, 6'291'456))));
  }
}

TEST_F(VanillaHearingTest, AMessageForWhichThereIsNoMemoryIsDiscardedAndNamed) {
  NodeOptions options = options_with_log();
  options.udp.memory_limit_bytes = 32 << 20;
  Node node = Node::open(options).value();
  auto sub = node.subscriber<PointCloud2>("points", {.reliability = reliable}).value();
  VanillaWriter writer(network_.host(1), {});
  ASSERT_TRUE(writer.matches(1) && hears(sub, 1));
  writer.write_cloud(1, 25 << 20);
  EXPECT_TRUE(warns_of("no memory is free for it"));
  writer.write_cloud(2);
  EXPECT_EQ(next(sub), 2U);
  EXPECT_EQ(sub.status().discarded, 1U);
}

TEST_F(VanillaHearingTest, SamplesOutliveTheirWriterAndTheirSubscriber) {
  std::optional<Sample<PointCloud2>> kept;
  {
    Node node = open(Way::udp);
    auto sub = node.subscriber<PointCloud2>("points").value();
    VanillaWriter writer(network_.host(1), {});
    ASSERT_TRUE(writer.matches(1));
    writer.write_cloud(4);
    ASSERT_TRUE(sub.wait(hang_timeout));
    kept = sub.take();
  }
  EXPECT_TRUE(std::ranges::equal(kept->cdr().subspan(4), body_of(cloud(4))));
}

TEST_F(VanillaHearingTest, TheLogAndTheStatusSayWhyAWriterIsNotHeard) {
  Node node = Node::open(options_with_log()).value();
  auto sub = node.subscriber<PointCloud2>("points", {.reliability = reliable}).value();
  const auto is_refused = [&](const VanillaWriter::How& how, const std::string& why) {
    VanillaWriter writer(network_.host(1), how);
    EXPECT_TRUE(warns_of("points: a writer of DDS is not heard: " + why)) << how.kind;
    EXPECT_TRUE(eventually([&] { return writer_of(sub).reason.starts_with(why); })) << writer_of(sub).reason;
    EXPECT_FALSE(writer_of(sub).matched);
    writer.end();
    EXPECT_TRUE(eventually([&] { return sub.status().writers.empty(); }));
  };
  is_refused({.kind = "other_type"}, "its type is 'std_msgs::msg::dds_::Header_'");
  is_refused(
      {.kind = "keyed"},
      "its type is 'house_msgs::msg::dds_::Room_', and that of the subscriber is "
      "'sensor_msgs::msg::dds_::PointCloud2_'; its type has keys, and that of the subscriber has none");
  is_refused({.kind = "xcdr2"}, "it sends XCDR2");
  is_refused({.kind = "partition"}, "it is in the partition 'left'");
  is_refused({.kind = "other_hash"}, "its type has another definition (RIHS01_0)");
  is_refused({.reliability = "best_effort"}, "incompatible QoS: reliability best_effort is offered");
  EXPECT_EQ(warnings_with("not heard"), 6);
}

TEST_F(VanillaHearingTest, ANodeThatHearsThemNeverMatchesNoWriter) {
  Node never = open(Way::udp, VanillaDds::never);
  Node hearing = open(Way::udp);
  auto of_never_node = never.subscriber<PointCloud2>("never").value();
  auto sub = hearing.subscriber<PointCloud2>("points").value();
  VanillaWriter of_never(network_.host(1), {.topic = "rt/never"});
  VanillaWriter writer(network_.host(1), {});
  ASSERT_TRUE(writer.matches(1) && hears(sub, 1));
  EXPECT_EQ(of_never.matched(), 0U);
  EXPECT_THAT(of_never_node.status().writers, IsEmpty());
}

bool is_in_default_partition(const dds_builtintopic_endpoint_t& reader) {
  std::uint32_t partitions = 0;
  return !dds_qget_partition(reader.qos, &partitions, nullptr) || partitions == 0;
}

// Else each pair of a publisher and a subscriber would match in DDS as well.
TEST_F(VanillaHearingTest, TheDdsReaderIsInThePartitionOfWritersOnlyWhileOneIsThere) {
  Node node = open(Way::udp, VanillaDds::always);
  auto sub = node.subscriber<PointCloud2>("points").value();
  VanillaReader onlooker(network_.host(1), {.topic = "rt/other"});
  auto pub = node.publisher<PointCloud2>("other").value();
  ASSERT_TRUE(onlooker.matches(1)) << "the node is found";
  const dds_entity_t participant = dds_create_participant(VanillaProcess::domain(), nullptr, nullptr);
  const dds_entity_t announced =
      dds_create_reader(participant, DDS_BUILTIN_TOPIC_DCPSSUBSCRIPTION, nullptr, nullptr);
  const auto readers_of_points = [&] {
    std::ptrdiff_t count = 0;
    std::array<void*, 64> samples{};
    std::array<dds_sample_info_t, 64> infos{};
    const auto taken = dds_read_mask(announced, samples.data(), infos.data(), 64, 64,
                                     DDS_ANY_STATE | DDS_ALIVE_INSTANCE_STATE);
    for (std::size_t i = 0; i < static_cast<std::size_t>(std::max(taken, 0)); ++i) {
      const auto* const reader = static_cast<const dds_builtintopic_endpoint_t*>(samples[i]);
      if (infos[i].valid_data && infos[i].instance_state == DDS_IST_ALIVE &&
          std::string(reader->topic_name) == "rt/points" && is_in_default_partition(*reader))
        ++count;
    }
    dds_return_loan(announced, samples.data(), taken);
    return count;
  };
  EXPECT_TRUE(eventually([&] { return participant > 0; }));
  EXPECT_EQ(readers_of_points(), 0);
  VanillaWriter writer(network_.host(1), {});
  ASSERT_TRUE(writer.matches(1));
  EXPECT_TRUE(eventually([&] { return readers_of_points() == 1; }));
  writer.end();
  EXPECT_TRUE(eventually([&] { return readers_of_points() == 0; }));
  dds_delete(participant);
}

struct Localhost {
  const char* name;
  const char* variable;
  const char* value;
  const char* of_ros;  ///< the configuration that rmw_cyclonedds makes of the variable
};
class LocalhostTest : public VanillaHearingTest, public testing::WithParamInterface<Localhost> {};

TEST_P(LocalhostTest, NodesThatStayOnTheirHostAreHeardWhereTheEnvironmentSaysSo) {
  const std::string usual = std::getenv("CYCLONEDDS_URI");
  const auto start = [&](const char* topic) {
    setenv("CYCLONEDDS_URI", (usual + "," + GetParam().of_ros).c_str(), 1);
    auto writer = std::make_unique<VanillaWriter>(network_.host(0), VanillaWriter::How{.topic = topic});
    setenv("CYCLONEDDS_URI", usual.c_str(), 1);
    return writer;
  };
  setenv(GetParam().variable, GetParam().value, 1);
  const auto earlier = start("rt/earlier");
  Node node = open(Way::udp, VanillaDds::always);
  auto of_earlier = node.subscriber<PointCloud2>("earlier").value();
  auto of_later = node.subscriber<PointCloud2>("later").value();
  ASSERT_TRUE(hears(of_earlier, 1) && earlier->matches(1));
  const auto later = start("rt/later");
  ASSERT_TRUE(hears(of_later, 1) && later->matches(1));
  earlier->write_cloud(1);
  later->write_cloud(2);
  EXPECT_EQ(next(of_earlier), 1U);
  EXPECT_EQ(next(of_later), 2U);
}

INSTANTIATE_TEST_SUITE_P(
    Of, LocalhostTest,
    testing::Values(Localhost{"humble", "ROS_LOCALHOST_ONLY", "1",
                              "<General><Interfaces><NetworkInterface address=\"127.0.0.1\"/></></>"},
                    Localhost{"iron", "ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST",
                              "<General><AllowMulticast>false</></>,<Discovery><ParticipantIndex>auto</>"
                              "<MaxAutoParticipantIndex>32</><Peers><Peer address=\"localhost\"/></></>"}),
    [](const auto& one) { return one.param.name; });

struct Published {
  std::atomic<std::uint32_t> number{0};
  std::atomic<std::size_t> vanilla_readers{0};
  std::atomic<bool> failed{false};
};

/// A process that publishes clouds with rising numbers, and serves vanilla readers always.
NodeProcessWith<Published>::Role publishes() {
  return [](Node& node, Published& published) {
    auto pub = node.publisher<PointCloud2>("points", {.reliability = reliable}).value();
    test::Pace sensor(std::chrono::milliseconds(5));
    for (std::uint32_t number = 1;; ++number) {
      PointCloud2 cloud;
      cloud.height = number;
      pub.publish(cloud);
      published.number = number;
      published.vanilla_readers = pub.status().vanilla_readers;
      sensor.await_turn();
    }
  };
}

TEST_F(VanillaHearingTest, WhatAPublisherOfSftSendsByDdsDoesNotComeTwice) {
  NodeOptions options = node_options(Way::udp, "lidar");
  options.vanilla_dds = VanillaDds::always;
  const NodeProcessWith<Published> publisher(network_.host(1), options, publishes());
  Node node = open(Way::udp, VanillaDds::always);
  auto sub = node.subscriber<PointCloud2>("points", {.reliability = reliable, .depth = 1000}).value();
  VanillaWriter writer(network_.host(1), {});  // so that the subscriber has a DDS reader
  VanillaReader reader(network_.host(1), {});  // so that the publisher sends by DDS
  ASSERT_TRUE(writer.matches(2) && hears(sub, 2));
  ASSERT_TRUE(eventually([&] { return publisher.report().vanilla_readers == 1; }));
  writer.write_cloud(1'000'000);
  std::set<std::pair<TransportKind, std::uint32_t>> came;
  const std::uint32_t enough = publisher.report().number + 300;
  for (std::uint32_t number = 0; number < enough;) {
    ASSERT_TRUE(sub.wait(hang_timeout));
    const auto sample = sub.take();
    const bool is_of_sft = sample->height() < 1'000'000;
    if (is_of_sft) number = sample->height();
    EXPECT_EQ(sample.info().transport, is_of_sft ? TransportKind::udp : TransportKind::dds);
    EXPECT_TRUE(came.emplace(sample.info().transport, sample->height()).second) << sample->height();
  }
  EXPECT_THAT(came, Contains(std::pair(TransportKind::dds, 1'000'000U)));
  EXPECT_FALSE(reader.take().body.empty()) << "the publisher did send by DDS";
}

TEST_F(VanillaHearingTest, MalformedAndForeignEncodingsAreRefusedCountedAndNamedOnce) {
  Node node = Node::open(options_with_log()).value();
  auto sub = node.subscriber<PointCloud2>("points", {.reliability = reliable, .depth = 10}).value();
  VanillaForger forger(network_.host(1));
  ASSERT_TRUE(forger.is_matched() && hears(sub, 1));
  const std::vector<std::byte> sound = encoded(cloud(1));
  std::vector<std::byte> cut = sound, cut_and_swapped = BigEndianBytes(cloud(1)).bytes(), xcdr2 = sound;
  cut.resize(sound.size() / 2);
  cut_and_swapped.resize(sound.size() / 2);
  xcdr2[1] = std::byte{7};
  for (int i = 0; i < 3; ++i) {
    for (const auto& bytes : {cut, cut_and_swapped, xcdr2, {sound.begin(), sound.begin() + 4}})
      forger.write_sample(bytes);
  }
  forger.write_sample(sound);
  EXPECT_EQ(next(sub), 1U);
  EXPECT_EQ(sub.status().discarded, 12U);
  EXPECT_TRUE(warns_of(
      "points: a sample of a writer of DDS cannot be read, and is discarded: the message does not fit"));
  EXPECT_TRUE(warns_of("not encoded as XCDR1"));
  EXPECT_EQ(warnings_with("cannot be read"), 2);
}

TEST_F(VanillaHearingTest, ANodeWithPlainNamesHearsAndServesEndpointsWithTheNamesOfSft) {
  Node node = Node::open(with_plain_names(node_options(Way::udp, "camera"))).value();
  auto sub = node.subscriber<PointCloud2>("points", {.reliability = reliable}).value();
  auto pub = node.publisher<PointCloud2>("scans").value();
  VanillaForger forger(network_.host(1), "points", "sensor_msgs::msg::PointCloud2");
  ASSERT_TRUE(forger.is_matched() && hears(sub, 1));
  forger.write_sample(encoded(cloud(3)));
  EXPECT_EQ(next(sub), 3U);
  const dds_entity_t participant = dds_create_participant(VanillaProcess::domain(), nullptr, nullptr);
  const core::RawTopic scans = core::raw_topic(participant, "scans", "sensor_msgs::msg::PointCloud2");
  ASSERT_GT(dds_create_reader(participant, scans.entity, nullptr, nullptr), 0);
  EXPECT_TRUE(serves(pub, 1));
  dds_delete(participant);
}

TEST_F(VanillaHearingTest, ATopicThatIsMisspeltIsNamedWithThatOfAWriterWithPlainNames) {
  Node node = Node::open(with_plain_names(options_with_log())).value();
  const VanillaForger of_other_names(network_.host(1), "rt/poinst");
  const VanillaForger forger(network_.host(1), "points", "sensor_msgs::msg::PointCloud2");
  const auto misspelt = node.subscriber<PointCloud2>("pionts").value();
  EXPECT_TRUE(warns_of("topic 'pionts': no publisher of it was seen; did you mean 'points', which node "));
}

TEST_F(VanillaHearingTest, BigEndianNumbersAreSwapped) {
  Node node = open(Way::udp);
  auto sub = node.subscriber<PointCloud2>("points", {.reliability = reliable, .depth = 10}).value();
  VanillaForger forger(network_.host(1));
  ASSERT_TRUE(forger.is_matched() && hears(sub, 1));
  for (std::uint32_t i = 1; i <= 4; ++i) {
    PointCloud2 sent = cloud(0x01020304 * i, 1000 + i);
    sent.fields[0].offset = 0x0A0B0C0D;
    sent.is_dense = true;
    forger.write_sample(BigEndianBytes(sent).bytes());
    ASSERT_TRUE(sub.wait(hang_timeout));
    const auto sample = sub.take();
    EXPECT_TRUE(std::ranges::equal(sample.cdr().subspan(4), body_of(sent)));
    EXPECT_EQ(sample->height(), 0x01020304 * i);
  }
  EXPECT_EQ(sub.status().discarded, 0U);
}

TEST_F(VanillaHearingTest, MutatedSamplesCostNoMoreThanTheyAreWorth) {
  Random random(test_seed());
  const auto below = [&](std::size_t end) { return static_cast<std::size_t>(random() % end); };
  Node node = Node::open(options_with_log()).value();
  auto sub =
      node.subscriber<PointCloud2, sft::recorded>("points", {.reliability = reliable, .depth = 16}).value();
  VanillaForger forger(network_.host(1));
  ASSERT_TRUE(forger.is_matched() && hears(sub, 1));
  const std::array sound{encoded(cloud(1)), BigEndianBytes(cloud(1)).bytes()};
  const std::size_t before = mallinfo2().uordblks;
  constexpr std::uint32_t samples = 3000;
  for (std::uint32_t i = 0; i < samples; ++i) {
    std::vector<std::byte> mutated = sound[i % 3 == 0 ? 1 : 0];
    // Cyclone itself drops samples whose first octets it does not know.
    for (std::size_t n = below(4); n > 0; --n)
      mutated[4 + below(mutated.size() - 4)] = static_cast<std::byte>(below(256));
    if (i % 2 == 0) mutated.resize(4 + below(mutated.size() - 4));
    forger.write_sample(mutated);
    if (const auto sample = sub.take()) {
      EXPECT_TRUE(sample.to_partial());
    }
  }
  forger.write_sample(encoded(cloud(77)));
  bool came = false;
  while (!came && sub.wait(hang_timeout)) {
    const auto sample = sub.take();
    came = sample->height() == 77U && sample->width() == 78U;
  }
  EXPECT_TRUE(came);
  EXPECT_GT(sub.status().discarded, samples / 4);
  EXPECT_LT(mallinfo2().uordblks, before + (std::size_t{8} << 20));
}

}  // namespace
}  // namespace sft::test
