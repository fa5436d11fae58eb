// Publishers send to readers of plain DDS, which know nothing of SFT, on this host and on another host.
#include <dds/dds.h>
#include <dlfcn.h>
#include <gmock/gmock.h>

#include <atomic>
#include <builtin_interfaces/msg/Time.hpp>
#include <filesystem>
#include <set>
#include <utility>

#include "tests/support/other_threads.h"
#include "tests/support/pace.h"
#include "tests/support/temporary_directory.h"
#include "tests/system/vanilla_fixture.h"

namespace sft::test {
namespace {

using builtin_interfaces::msg::Time;
using testing::HasSubstr;

class VanillaServingTest : public VanillaTest {
 protected:
  template <class P>
  static void expect_served(const P& publisher, std::size_t readers) {
    EXPECT_TRUE(eventually([&] {
      const PublisherStatus status = publisher.status();
      return std::ranges::count_if(status.readers, &PublisherStatus::Reader::served) ==
             static_cast<std::ptrdiff_t>(readers);
    }));
  }
  /// Returns true if the reader finally gets a sample with this body.
  static bool comes_to(VanillaReader& reader, const std::vector<std::byte>& body) {
    for (;;) {
      const VanillaReader::Sample sample = reader.take();
      if (sample.body == body) return true;
      if (sample.body.empty()) return false;
    }
  }
};

struct Case {
  Way way = Way::udp;
  std::size_t host = 0;  ///< the number of the reader's host
  const char* reliability = "reliable";
};
std::string name_of_case(const testing::TestParamInfo<Case>& one) {
  return std::string(one.param.way == Way::shm ? "shm_" : "udp_") +
         (one.param.host == 0 ? "same_host_" : "other_host_") + one.param.reliability;
}
class VanillaReadersTest : public VanillaServingTest, public testing::WithParamInterface<Case> {};

TEST_P(VanillaReadersTest, GetTheBytesAndTheStampOfEachMessage) {
  Node node = open(GetParam().way);
  auto pub = node.publisher<PointCloud2>("points").value();
  auto sub = node.subscriber<PointCloud2>("points").value();
  VanillaReader reader(network_.host(GetParam().host), {.reliability = GetParam().reliability});
  ASSERT_TRUE(serves(pub, 1) && reader.matches(1));
  expect_served(pub, 1);
  for (std::uint32_t i = 0; i < 5; ++i) {
    const std::size_t bytes = i < 4 ? 1000 + i : 300'000;  // these sizes need every possible amount of
                                                           // padding
    ASSERT_EQ(pub.publish(cloud(i, bytes)), PublishStatus::ok);
    const VanillaReader::Sample sample = reader.take();
    EXPECT_EQ(sample.body, body_of(cloud(i, bytes)));
    ASSERT_TRUE(sub.wait(hang_timeout));
    const auto ours = sub.take();
    EXPECT_EQ(sample.stamp, ours.info().source_stamp.time_since_epoch());
    EXPECT_FALSE(sub.take()) << "once each";
  }
}

INSTANTIATE_TEST_SUITE_P(Of, VanillaReadersTest,
                         testing::Values(Case{Way::udp, 0, "reliable"}, Case{Way::udp, 1, "reliable"},
                                         Case{Way::udp, 1, "best_effort"}, Case{Way::shm, 0, "reliable"},
                                         Case{Way::shm, 1, "best_effort"}),
                         name_of_case);

TEST_F(VanillaServingTest, AReaderThatWasThereBeforeThePublisherIsServed) {
  for (const std::size_t host : {0, 1}) {
    VanillaReader reader(network_.host(host), {});
    Node node = open(Way::udp);
    auto pub = node.publisher<PointCloud2>("points").value();
    ASSERT_TRUE(serves(pub, 1) && reader.matches(1));
    pub.publish(cloud(7));
    EXPECT_EQ(reader.take().body, body_of(cloud(7)));
  }
}

TEST_F(VanillaServingTest, ReadersCountAsSubscribersForWhoeverWaitsForThem) {
  Node node = open(Way::udp);
  std::atomic<std::size_t> reported{0};
  PublisherOptions options;
  options.on_readers_changed = [&](const PublisherStatus& status) { reported = status.vanilla_readers; };
  auto pub = node.publisher<PointCloud2>("points", options).value();
  EXPECT_FALSE(pub.wait_for_subscribers(1, std::chrono::milliseconds(0)));
  VanillaReader first(network_.host(1), {});
  ASSERT_TRUE(pub.wait_for_subscribers(1, hang_timeout));
  VanillaReader second(network_.host(0), {});
  ASSERT_TRUE(pub.wait_for_subscribers(2, hang_timeout));
  EXPECT_TRUE(eventually([&] { return reported == 2; }));
  ASSERT_TRUE(first.matches(1) && second.matches(1));
  pub.publish(cloud(7));
  EXPECT_EQ(first.take().body, body_of(cloud(7)));
  EXPECT_EQ(second.take().body, body_of(cloud(7)));
}

TEST_F(VanillaServingTest, TheDomainHasDdsEndpointsAndNoParticipantIsThereForThemBefore) {
  Node node = open(Way::udp);
  (void)node.domain();
  const auto threads = names_of_threads();
  EXPECT_TRUE(node.domain().publishers.empty());
  VanillaReader reader(network_.host(1), {});
  ASSERT_TRUE(eventually([&] { return node.domain().subscribers.size() == 1; }));
  const DomainSnapshot domain = node.domain();
  const DomainSnapshot::Endpoint& found = domain.subscribers.at(0);
  EXPECT_EQ(found.topic, "points");
  EXPECT_EQ(found.type_name, "sensor_msgs::msg::PointCloud2");
  EXPECT_EQ(found.qos.reliability, reliable);
  ASSERT_TRUE(found.dds);
  EXPECT_EQ(found.dds->topic, "rt/points");
  EXPECT_EQ(found.dds->guid.size(), 32U);
  ASSERT_EQ(domain.dds_nodes.size(), 1U);
  EXPECT_EQ(domain.dds_nodes[0].name, found.node);
  EXPECT_THAT(domain.dds_nodes[0].process, HasSubstr("vanilla_reader ("));
  EXPECT_EQ(domain.dds_nodes[0].endpoints, 1U);
  EXPECT_GT(names_of_threads().size(), threads.size());
  reader.kill_now();
  EXPECT_TRUE(eventually([&] { return node.domain().subscribers.empty(); }));
}

TEST_F(VanillaServingTest, LatchedReadersGetWhatThePublisherRetainsInOrderAndThenWhatFollows) {
  Node node = open(Way::shm);
  auto pub =
      node.publisher<PointCloud2>("points", {.durability = transient_local, .history_depth = 3}).value();
  for (std::uint32_t i = 0; i < 5; ++i) pub.publish(cloud(i));
  VanillaReader late(network_.host(1), {.durability = "latched"});
  for (std::uint32_t i = 2; i < 5; ++i) EXPECT_EQ(late.take().body, body_of(cloud(i)));
  VanillaReader later(network_.host(0), {.durability = "latched"});
  for (std::uint32_t i = 2; i < 5; ++i) EXPECT_EQ(later.take().body, body_of(cloud(i)));
  pub.publish(cloud(5));
  EXPECT_EQ(late.take().body, body_of(cloud(5)));
  EXPECT_EQ(later.take().body, body_of(cloud(5)));
}

TEST_F(VanillaServingTest, AfterAReaderWasKilledTheNextOneIsServed) {
  Node node = open(Way::udp);
  auto pub = node.publisher<PointCloud2>("points").value();
  VanillaReader first(network_.host(1), {});
  ASSERT_TRUE(serves(pub, 1));
  first.kill_now();
  ASSERT_TRUE(serves(pub, 0));
  EXPECT_EQ(pub.publish(cloud(1)), PublishStatus::ok);
  VanillaReader second(network_.host(1), {});
  ASSERT_TRUE(serves(pub, 1) && second.matches(1));
  pub.publish(cloud(2));
  EXPECT_EQ(second.take().body, body_of(cloud(2)));
}

TEST_F(VanillaServingTest, AReaderThatWasStoppedHoldsFewSamplesAndNobodyElseMissesOne) {
  use_lease("100 s");
  NodeOptions options = node_options(Way::udp, "camera");
  options.udp.memory_limit_bytes = 32 << 20;
  Node node = Node::open(options).value();
  auto pub = node.publisher<PointCloud2>("points", {.reliability = reliable}).value();
  auto sub = node.subscriber<PointCloud2>("points", {.reliability = reliable}).value();
  VanillaReader stopped(network_.host(1), {});
  VanillaReader other(network_.host(1), {});
  ASSERT_TRUE(serves(pub, 2) && stopped.matches(1) && other.matches(1));
  expect_served(pub, 1);
  expected_warning = "a reader of DDS does not acknowledge";  // if the samples take some seconds
  stopped.hold_up();
  for (std::uint32_t i = 0; i < 60; ++i) {
    ASSERT_EQ(pub.publish(cloud(i, 1'000'000)), PublishStatus::ok);
    ASSERT_TRUE(sub.wait(hang_timeout));
    const auto ours = sub.take();
    EXPECT_EQ(ours->height(), i);
    EXPECT_EQ(other.take().body, body_of(cloud(i, 1'000'000)));
  }
  stopped.let_go();
  EXPECT_TRUE(comes_to(stopped, body_of(cloud(59, 1'000'000))));
}

class LongLeaseTest : public VanillaServingTest {
 protected:
  LongLeaseTest() { use_lease("100 s"); }
};

class SilentReadersTest : public LongLeaseTest {
 protected:
  bool is_named_by_domain() {
    const DomainSnapshot domain = node_.domain();
    return std::ranges::any_of(domain.pairs, [](const DomainSnapshot::Pair& pair) {
      return pair.reason.find("does not acknowledge") != pair.reason.npos;
    });
  }
  /// Publishes until the log names the reader that does not answer. The other one gets each sample.
  void expect_named() {
    Pace pace(50ms);
    for (std::uint32_t i = 1; i < 1000 && warnings_with("does not acknowledge") == 0;
         ++i, pace.await_turn()) {
      ASSERT_EQ(pub_.publish(cloud(i)), PublishStatus::ok);
      EXPECT_EQ(other_.take().body, body_of(cloud(i)));
    }
    EXPECT_EQ(warnings_with("points: a reader of DDS does not acknowledge what it is sent"), 1);
    EXPECT_TRUE(eventually([&] { return is_named_by_domain(); }));
  }

  Node node_ = Node::open(options_with_log()).value();
  Publisher<PointCloud2> pub_ = node_.publisher<PointCloud2>("points").value();
  VanillaReader silent_{network_.host(1), {}}, other_{network_.host(0), {}};
};

TEST_F(SilentReadersTest, AReaderThatIsStoppedIsNamedOnceUntilItGoesOn) {
  ASSERT_TRUE(serves(pub_, 2) && silent_.matches(1) && other_.matches(1));
  EXPECT_FALSE(is_named_by_domain());
  silent_.hold_up();
  expect_named();
  silent_.let_go();
  EXPECT_TRUE(eventually([&] { return !is_named_by_domain(); }));
}

TEST_F(SilentReadersTest, AReaderWhoseAnswersAFirewallDropsIsNamedOnce) {
  ASSERT_TRUE(serves(pub_, 2) && silent_.matches(1) && other_.matches(1));
  const auto& host = network_.host(1);
  const std::string to_publisher = "ip daddr " + hosts::EmulatedNetwork::address(0) + " udp dport > 0 drop";
  if (!host.run({"nft", "add table ip sft_test"})) GTEST_SKIP() << "needs nft";
  ASSERT_TRUE(host.run({"nft", "add chain ip sft_test out { type filter hook output priority 0; }"}));
  ASSERT_TRUE(host.run({"nft", "add rule ip sft_test out " + to_publisher}));
  expect_named();
}

TEST_F(VanillaServingTest, TheLogSaysWhyAReaderIsNotServed) {
  Node node = Node::open(options_with_log()).value();
  auto pub = node.publisher<PointCloud2>("points").value();
  auto of_time = node.publisher<Time>("time").value();
  VanillaReader latched(network_.host(1), {.durability = "latched"});
  VanillaReader of_other(network_.host(1), {.topic = "rt/time"});
  EXPECT_TRUE(
      warns_of("points: a reader of DDS is not served: incompatible QoS: durability volatile is offered"));
  EXPECT_TRUE(
      warns_of("time: a reader of DDS is not served: its type is 'sensor_msgs::msg::dds_::PointCloud2_'"));
  VanillaReader keyed(network_.host(1), {.kind = "keyed"});
  EXPECT_TRUE(warns_of("its type has keys, and that of the publisher has none"));
  VanillaReader xcdr2(network_.host(1), {.kind = "xcdr2"});
  EXPECT_TRUE(warns_of("points: a reader of DDS is not served: it takes XCDR2 only"));
  VanillaReader other(network_.host(1), {.kind = "other_hash"});
  EXPECT_TRUE(
      warns_of("points: a reader of DDS misreads what it gets: its type has another definition (RIHS01_0) "
               "than that of "
               "the publisher (RIHS01_"));
}

TEST_F(VanillaServingTest, WithoutSuchNodesThereIsNothingMoreThanIfTheyWereNeverServed) {
  Node node = open(Way::udp, VanillaDds::never);
  auto pub = node.publisher<PointCloud2>("points").value();
  // The threads of discovery start one after the other.
  std::multiset<std::string> before;
  const auto are_all = [&] {
    std::multiset<std::string> now = names_of_threads();
    return std::exchange(before, now) == now;
  };
  ASSERT_TRUE(eventually(are_all, hang_timeout, 200ms));
  Node served = open(Way::udp);
  auto other = served.publisher<PointCloud2>("points").value();
  auto sub = node.subscriber<PointCloud2>("points").value();
  expect_served(pub, 1);
  expect_served(other, 1);
  std::multiset<std::string> of_second_node = names_of_threads();
  for (const std::string& name : before) {
    if (const auto known = of_second_node.find(name); known != of_second_node.end())
      of_second_node.erase(known);
  }
  EXPECT_THAT(of_second_node, testing::Not(testing::Contains("recv"))) << "as a thread of Cyclone is called";
  EXPECT_THAT(of_second_node, testing::Not(testing::Contains(HasSubstr("dds"))));
}

TEST_F(VanillaServingTest, APublisherOfANodeThatServesThemNeverIsNotMatched) {
  Node node = open(Way::udp, VanillaDds::never);
  Node serving = open(Way::udp);
  auto never = node.publisher<PointCloud2>("never").value();
  auto pub = serving.publisher<PointCloud2>("points").value();
  VanillaReader of_never(network_.host(1), {.topic = "rt/never"});
  VanillaReader reader(network_.host(1), {});
  ASSERT_TRUE(serves(pub, 1) && reader.matches(1));
  EXPECT_EQ(of_never.matched(), 0U);
  EXPECT_EQ(never.status().vanilla_readers, 0U);
}

// If such a program were served, it would get its own messages back when it forwards messages of DDS to
// SFT.
TEST_F(VanillaServingTest, AProgramThatSpeaksDdsItselfServesNobodyUnlessItSaysSo) {
  const dds_entity_t participant = dds_create_participant(VanillaProcess::domain(), nullptr, nullptr);
  Node node = open(Way::udp);
  Node serving = open(Way::udp, VanillaDds::always);
  auto automatic = node.publisher<PointCloud2>("automatic").value();
  auto pub = serving.publisher<PointCloud2>("points").value();
  VanillaReader of_automatic(network_.host(1), {.topic = "rt/automatic"});
  VanillaReader reader(network_.host(1), {});
  ASSERT_TRUE(serves(pub, 1) && reader.matches(1));
  EXPECT_EQ(of_automatic.matched(), 0U);
  dds_delete(participant);
}

/// A second copy of Cyclone DDS in this process, as a program has that loads ROS 2's own.
class OtherCyclone {
 public:
  OtherCyclone() {
    Dl_info ours{};
    dladdr(reinterpret_cast<void*>(&::dds_create_participant), &ours);
    const std::filesystem::path copy = folder_.path() / "libddsc_of_another.so";
    std::filesystem::copy_file(ours.dli_fname, copy);
    library_ = dlopen(copy.c_str(), RTLD_NOW | RTLD_LOCAL | RTLD_DEEPBIND);
  }
  dds_entity_t create_participant() const {
    const auto create =
        reinterpret_cast<decltype(&::dds_create_participant)>(function("dds_create_participant"));
    return create == nullptr ? -1 : create(VanillaProcess::domain(), nullptr, nullptr);
  }
  void destroy(dds_entity_t entity) const {
    reinterpret_cast<decltype(&::dds_delete)>(function("dds_delete"))(entity);
  }

 private:
  void* function(const char* name) const { return library_ == nullptr ? nullptr : dlsym(library_, name); }

  const TemporaryDirectory folder_;
  void* library_ = nullptr;
};

TEST_F(VanillaServingTest, AProgramThatHasAnotherCycloneDdsServesThemWhicheverIsUsedFirst) {
#ifdef __SANITIZE_ADDRESS__
  GTEST_SKIP() << "RTLD_DEEPBIND does not go with the address sanitizer";
#endif
  const OtherCyclone other;
  for (const bool is_first : {true, false}) {
    dds_entity_t participant = is_first ? other.create_participant() : 0;
    Node node = open(Way::udp, VanillaDds::always);
    auto pub = node.publisher<PointCloud2>("points").value();
    VanillaReader reader(network_.host(1), {});
    ASSERT_TRUE(serves(pub, 1) && reader.matches(1));
    if (!is_first) participant = other.create_participant();
    ASSERT_GT(participant, 0);
    pub.publish(cloud(3));
    EXPECT_EQ(reader.take().body, body_of(cloud(3)));
    other.destroy(participant);
  }
}

TEST_F(VanillaServingTest, AProgramThatHasTheLoopbackOnlyServesThemIfItSaysSo) {
  const auto host = hosts::NetworkNamespace::create().value();
  ASSERT_TRUE(host.run({"ip", "link", "set", "lo", "up"}));
  ASSERT_TRUE(host.run({"ip", "link", "set", "lo", "multicast", "on"}));
  ASSERT_TRUE(host.enter());
  Node node = open(Way::udp, VanillaDds::always);
  auto pub = node.publisher<PointCloud2>("points").value();
  VanillaReader reader(host, {});
  ASSERT_TRUE(serves(pub, 1) && reader.matches(1));
  pub.publish(cloud(3));
  EXPECT_EQ(reader.take().body, body_of(cloud(3)));
}

}  // namespace
}  // namespace sft::test
