// Readers that are served by a multicast group, over loopback.
#include <gtest/gtest.h>
#include <net/if.h>

#include <algorithm>
#include <atomic>
#include <memory>
#include <random>
#include <span>
#include <string>

#include "core/seam/delivery.h"
#include "core/seam/gate.h"
#include "tests/support/test_seed.h"
#include "tests/transports/udp/faulty_io.h"
#include "tests/transports/udp/transport_fixture.h"
#include "udp_transport/io/interfaces.h"
#include "udp_transport/io/multicast_links.h"

namespace sft::udp {
namespace {

using namespace std::chrono_literals;
using test::eventually;
using test::make_image;
using test::Publisher;
using test::Subscriber;

class MulticastTest : public TransportTest {
 protected:
  struct Process {
    std::unique_ptr<core::Network> transport;
    std::unique_ptr<Subscriber> subscriber;
    std::string mask;
    bool reliable = false;
    std::uint32_t since = 0;  ///< the number of samples that were published before the process was added
    std::shared_ptr<core::Gate> gate{};  ///< the gate of a reader with a maximum rate
  };

  static UdpOptions everywhere() { return {.multicast = Multicast::everywhere}; }

  void SetUp() override {
    TransportTest::SetUp();
    if (IsSkipped()) return;
    writer_ = open(everywhere());
    publisher_ = std::make_unique<Publisher>(*writer_, own_id(), 0, book_);
  }
  /// Returns a random id, because the address of a group follows from the id of the writer, and other tests
  /// on the same host may run at the same time.
  static core::EndpointId own_id() {
    std::random_device random;
    return core::EndpointId{random()} << 32 | random();
  }

  void add(const std::string& mask, bool reliable, const DecorateIo& decorate = {}) {
    Process process{open(everywhere(), decorate), nullptr, mask, reliable, published_};
    process.subscriber =
        std::make_unique<Subscriber>(*process.transport, std::vector{mask}, 100'000, processes_.size() + 1);
    if (reliable) process.subscriber->listen_reliably_to(publisher_->id());
    if (!reliable) process.subscriber->listen_to(publisher_->id());
    processes_.push_back(std::move(process));
  }
  void serve() { serve(processes_.size()); }
  void serve(std::size_t first) {
    std::vector<Publisher::Reader> readers;
    for (const Process& process : std::span(processes_).first(first))
      readers.push_back(
          {test::loopback_address(*process.transport), process.mask, process.reliable, process.gate});
    publisher_->serve(readers);
  }
  void publish(std::size_t bytes = 100) {
    publisher_->publish(make_image(bytes, ++published_));
    writer_->poll(std::chrono::steady_clock::now());
  }
  std::string state_of(core::EndpointId reader) { return publisher_->port().multicast(reader); }
  bool hears(core::EndpointId reader) {
    const std::string state = state_of(reader);
    return state.starts_with("group ") && !state.ends_with("any more") && !state.ends_with("no more");
  }
  /// Returns true if a group reaches all readers except the first `first` ones.
  bool all_hear(std::size_t first = 0) {
    for (std::size_t reader = first + 1; reader <= processes_.size(); ++reader) {
      if (!hears(reader)) return false;
    }
    return true;
  }
  /// Waits until all readers have all samples, so that none has a backlog, and publishes the next one.
  void publish_in_turn(std::size_t bytes = 100) {
    await_all();
    publish(bytes);
  }
  void await_all() {
    for (const Process& process : processes_) {
      if (published_ > process.since) process.subscriber->await(published_ - process.since);
    }
  }
  /// Publishes until groups serve all readers except the first `first` ones.
  bool come_together(std::size_t first = 0) {
    return eventually([&] {
      publish_in_turn();
      return all_hear(first);
    });
  }
  /// Returns the average number of bytes that one more sample adds to the traffic. The sample is large, so
  /// that the heartbeats to the members do not matter: four of them have 128 bytes.
  std::uint64_t bytes_of_one() {
    constexpr int samples = 3;
    constexpr std::size_t data_bytes = 1000;
    publish_in_turn(data_bytes);
    await_all();
    const std::uint64_t before = publisher_->port().counters().bytes_sent;
    for (int i = 0; i < samples; ++i) publish_in_turn(data_bytes);
    await_all();
    return (publisher_->port().counters().bytes_sent - before) / samples;
  }
  /// Returns the same average while only the first reader is served.
  std::uint64_t bytes_of_one_to_the_first() {
    serve(1);
    for (Process& process : processes_) process.since = 4;
    processes_.front().since = 0;
    const std::uint64_t bytes = bytes_of_one();
    EXPECT_EQ(published_, processes_.back().since);
    return bytes;
  }
  void expect_all_of(std::size_t process) {
    const std::size_t count = published_ - processes_[process].since;
    const auto sequences = processes_[process].subscriber->await_sequences(count);
    ASSERT_EQ(sequences.size(), count) << "process " << process;
    for (std::size_t i = 0; i < count; ++i) ASSERT_EQ(sequences[i], processes_[process].since + 1 + i);
  }

  /// Returns the sequences of this publisher's samples in a process that also reads other publishers.
  std::vector<std::uint64_t> sequences_of_publisher(std::size_t process) {
    std::vector<std::uint64_t> sequences;
    for (const core::SampleHandle& sample : processes_[process].subscriber->await(0)) {
      if (sample->header().writer == publisher_->id()) sequences.push_back(sample->header().sequence);
    }
    return sequences;
  }

  test::Hold hold_;                     ///< outlives the transport that uses it
  std::atomic<bool> unreached_{false};  ///< outlives the transport that uses it
  const std::shared_ptr<core::DeliveryBook> book_ = std::make_shared<core::DeliveryBook>();
  std::unique_ptr<core::Network> writer_;
  std::unique_ptr<Publisher> publisher_;
  std::vector<Process> processes_;
  std::uint32_t published_ = 0;
};

INSTANTIATE_TEST_SUITE_P(Backends, MulticastTest, test::both_backends, test::backend_name);

TEST_P(MulticastTest, SendsOnceWhatSeveralAskFor) {
  for (int i = 0; i < 4; ++i) add("*", false);
  const std::uint64_t alone = 4 * bytes_of_one_to_the_first();
  serve();
  ASSERT_TRUE(come_together()) << state_of(1);
  EXPECT_LT(bytes_of_one(), alone / 3);
  for (std::size_t i = 0; i < 4; ++i) expect_all_of(i);
}

TEST_P(MulticastTest, CountsForEachReaderWhatWasSentToAllOfThem) {
  for (const bool reliable : {false, true, false}) add("name", reliable);
  serve();
  ASSERT_TRUE(come_together());
  for (int i = 0; i < 10; ++i) publish_in_turn();
  await_all();
  const std::size_t body = test::encoded_body(make_image(0), test::fields<test::Image>("name")).size();
  for (core::EndpointId reader = 1; reader <= processes_.size(); ++reader) {
    const core::Delivered counted = book_->of(reader);
    EXPECT_EQ(counted.sent, published_);
    EXPECT_EQ(counted.bytes, published_ * body);
    EXPECT_EQ(counted.dropped, 0U);
  }
}

TEST_P(MulticastTest, SendsReliablyToo) {
  for (int i = 0; i < 4; ++i) add("*", true);
  const std::uint64_t alone = 4 * bytes_of_one_to_the_first();
  serve();
  ASSERT_TRUE(come_together()) << state_of(1);
  EXPECT_LT(bytes_of_one(), alone / 3);
  for (const std::size_t bytes : {0, 5'000, 200'000, 1'000'000, 3}) publish(bytes);
  for (std::size_t i = 0; i < 4; ++i) expect_all_of(i);
  EXPECT_TRUE(all_hear());
}

TEST_P(MulticastTest, MergesMasksThatCostLessTogetherAndEachReaderTakesWhatContainsItsOwn) {
  add("height", false);
  add("width", true);
  add("height, stamp", true);
  serve();
  ASSERT_TRUE(come_together()) << state_of(1);
  publish();
  for (std::size_t i = 0; i < 3; ++i) expect_all_of(i);
  const auto samples = processes_[0].subscriber->await(published_);
  EXPECT_EQ(samples.front()->mask, test::fields<test::Image>("height"));
  EXPECT_EQ(samples.back()->mask, test::fields<test::Image>("height, width, stamp"));
}

TEST_P(MulticastTest, ServesAReaderAloneAtAMaximumRateThatNobodyElseHas) {
  for (int i = 0; i < 3; ++i) add("*", false);
  constexpr std::uint32_t an_hour_us = 3'600'000'000;
  processes_[2].gate = std::make_shared<core::Gate>(an_hour_us);
  processes_[2].subscriber->port().accept({{.wanted = {test::fields<test::Image>("*"), an_hour_us}}});
  serve();
  const auto publish_in_turn_to_others = [this] {
    for (const Process& process : std::span(processes_).first(2)) process.subscriber->await(published_);
    processes_[2].gate->consider(detail::FieldSource::of_nothing(),
                                 published_);  // the first sample of the hour passes
    publish();
  };
  ASSERT_TRUE(eventually([&] {
    publish_in_turn_to_others();
    return hears(1) && hears(2);
  })) << state_of(1);
  for (int i = 0; i < 50; ++i) publish_in_turn_to_others();
  EXPECT_EQ(
      state_of(3),
      "alone: no other host that could be in a group asks for the same at its rate or under its conditions");
  for (std::size_t i = 0; i < 2; ++i) expect_all_of(i);
  EXPECT_EQ(processes_[2].subscriber->await_sequences(1), (std::vector<std::uint64_t>{1}));
}

/// Every second sample passes the gate. A passed sample has a number, which shows a reader if a missing
/// sample was lost or withheld.
TEST_P(MulticastTest, ServesReadersWithOneMaximumRateByAGroupAtThatRate) {
  for (int i = 0; i < 2; ++i) add("*", false);
  for (const bool reliable : {false, true}) add("*", reliable);
  constexpr std::uint32_t period_us = 1000;
  const auto gate = std::make_shared<core::Gate>(period_us);
  for (Process& process : std::span(processes_).subspan(2)) {
    process.gate = gate;
    process.subscriber->port().accept({{.wanted = {test::fields<test::Image>("*"), period_us}}});
  }
  serve();
  std::vector<std::uint64_t> passed;
  const auto publish_in_turn_to_all = [&] {
    for (const Process& process : std::span(processes_).first(2)) process.subscriber->await(published_);
    for (const Process& process : std::span(processes_).subspan(2)) process.subscriber->await(passed.size());
    gate->consider(detail::FieldSource::of_nothing(), published_ * std::int64_t{period_us} * 500);
    publish();
    if (gate->passes()) passed.push_back(published_);
  };
  ASSERT_TRUE(eventually([&] {
    publish_in_turn_to_all();
    return all_hear();
  })) << state_of(1)
      << "; " << state_of(3);
  for (int i = 0; i < 50; ++i) publish_in_turn_to_all();
  EXPECT_TRUE(all_hear());
  EXPECT_NE(state_of(1), state_of(3)) << "they are in different groups";
  for (std::size_t i = 0; i < 2; ++i) expect_all_of(i);
  for (const Process& process : std::span(processes_).subspan(2)) {
    const auto samples = process.subscriber->await(passed.size());
    ASSERT_EQ(samples.size(), passed.size());
    for (std::size_t i = 0; i < passed.size(); ++i) {
      EXPECT_EQ(samples[i]->header().sequence, passed[i]);
      EXPECT_EQ(samples[i]->ordinal, i + 1);
      EXPECT_EQ(samples[i]->min_period_us, period_us);
    }
  }
}

TEST_P(MulticastTest, TakesInWhoComesLaterAndGoesOnWithoutWhoLeaves) {
  add("*", true);
  add("*", false);
  serve();
  ASSERT_TRUE(come_together());
  add("*", true);
  serve();
  ASSERT_TRUE(come_together()) << state_of(3);
  for (std::size_t i = 0; i < 3; ++i) expect_all_of(i);
  std::swap(processes_[0], processes_[2]);
  processes_.pop_back();  // removes the first reader
  serve();
  ASSERT_TRUE(come_together());
  expect_all_of(0);
  expect_all_of(1);
}

/// The group always carries exactly the fields that its readers request.
TEST_P(MulticastTest, FollowsMasksThatChange) {
  const std::string common = "name";
  add("data", false);
  for (int i = 0; i < 2; ++i) add(common, true);
  serve();
  ASSERT_TRUE(come_together());
  for (const std::string mask : {"height", "stamp", "data", "width"}) {
    Process& changing = processes_[0];
    changing.subscriber->port().accept({{.wanted = {test::fields<test::Image>(changing.mask)}},
                                        {.wanted = {test::fields<test::Image>(mask)}}});
    changing.mask = mask;
    serve();
    const FieldMask together = test::fields<test::Image>(common + ", " + mask);
    const auto carries_that = [&](const Process& process) {
      return process.subscriber->await(published_ - process.since).back()->mask == together;
    };
    EXPECT_TRUE(eventually([&] {
      publish_in_turn();
      return all_hear() && std::ranges::all_of(processes_, carries_that);
    })) << mask
        << ": " << state_of(1);
  }
  for (std::size_t i = 0; i < 3; ++i) expect_all_of(i);
}

/// The member receives no datagram of the group, as if its switch had removed it.
TEST_P(MulticastTest, ServesAloneAgainWhoHearsNothingMore) {
  add("*", true);
  add("*", true, [this](DatagramIo io) {
    io.receiver = std::make_unique<test::UnreachedReceiver>(std::move(io.receiver), unreached_);
    return io;
  });
  serve();
  ASSERT_TRUE(come_together());
  unreached_ = true;
  ASSERT_TRUE(eventually([this] {
    publish_in_turn();
    return !hears(2);
  }));
  EXPECT_TRUE(hears(1));
  expect_all_of(0);
  expect_all_of(1);
  unreached_ = false;
  EXPECT_TRUE(come_together());
  expect_all_of(1);
}

TEST_P(MulticastTest, LosesNothingThatIsReliableOnABadNetworkWhileOneComesAndGoes) {
  const auto seed = static_cast<unsigned>(sft::test::test_seed());
  SCOPED_TRACE(sft::test::how_to_repeat());
  for (unsigned i = 0; i < 4; ++i) {
    add("*", true, [seed, i](DatagramIo io) {
      return test::with_faults(std::move(io), {.loss = 0.05, .repetition = 0.02, .swap = 0.02}, seed + i);
    });
  }
  serve();
  ASSERT_TRUE(come_together());
  std::mt19937 random(seed);
  for (int n = 0; n < 300; ++n) {
    publish(random() % 8 == 0 ? random() % 100'000 : random() % 2000);
    if (n % 60 != 59) continue;
    serve(n % 120 == 59 ? 3 : 4);  // the last reader is not served for a while
  }
  for (std::size_t i = 0; i < 3; ++i) expect_all_of(i);
}

/// When the busy reader continues, both of its sockets have datagrams. Its own socket is read first, because
/// the datagram there arrived first.
TEST_P(MulticastTest, LosesNothingWhereAMemberOfAGroupThatEndsIsBusy) {
  add("*", false, [this](DatagramIo io) { return hold_.put_around(std::move(io)); });
  for (int i = 0; i < 2; ++i) add("*", false);
  serve();
  ASSERT_TRUE(come_together()) << state_of(1);
  await_all();
  Publisher other(*writer_, own_id());
  processes_[0].subscriber->listen_to(other.id());
  other.serve({{test::loopback_address(*processes_[0].transport)}});
  hold_.begin();
  other.publish(make_image(100, 1));
  ASSERT_TRUE(eventually([this] { return hold_.stops_it(); }));
  other.publish(make_image(100, 2));
  publish();
  serve(2);  // the two readers get another group
  publish();
  hold_.end();
  processes_[0].subscriber->await(published_ + 2, 1s);
  EXPECT_EQ(sequences_of_publisher(0), first_numbers(published_)) << hold_.arrivals();
}

/// When a member's mask changes, the other members get a new group. Until all of them have reported, each
/// sample is also sent to each of them alone. Meanwhile samples of another publisher arrive at the members'
/// own sockets.
class ChangingGroupsTest : public MulticastTest {
 protected:
  static constexpr std::size_t members = 8;

  void SetUp() override {
    MulticastTest::SetUp();
    if (IsSkipped()) return;
    other_ = std::make_unique<Publisher>(*writer_, own_id());
    std::vector<Publisher::Reader> others;
    for (std::size_t i = 0; i < members; ++i) {
      add("*", i % 2 == 1);
      Process& process = processes_[i];
      process.subscriber->port().accept({{.wanted = {test::fields<test::Image>("*")}},
                                         {.wanted = {test::fields<test::Image>("data, name")}}});
      beside_.push_back(std::make_unique<Subscriber>(*process.transport, std::vector<std::string>{"width"}));
      beside_.back()->listen_to(other_->id());
      others.push_back({test::loopback_address(*process.transport), "width"});
    }
    other_->serve(others);
    serve();
  }
  /// Changes the masks one after the other, except those of the last two members, which are in every group.
  void change_the_masks_of_the_first_six(const char* mask, std::size_t bytes) {
    ASSERT_TRUE(come_together()) << state_of(1);
    for (std::size_t changing = 0; changing + 2 < members; ++changing) {
      ASSERT_TRUE(come_together(changing)) << state_of(members);
      processes_[changing].mask = mask;
      other_->publish(make_image(100, 1));
      publish(bytes);
      serve();
      publish(bytes);
    }
  }

  std::unique_ptr<Publisher> other_;
  std::vector<std::unique_ptr<Subscriber>> beside_;  ///< for each process a subscriber to the other publisher
};

INSTANTIATE_TEST_SUITE_P(Backends, ChangingGroupsTest, test::both_backends, test::backend_name);

TEST_P(ChangingGroupsTest, LoseNothingAndKeepTheOrder) {
  for (const char* mask : {"data, name", "*", "data, name"}) change_the_masks_of_the_first_six(mask, 100);
  for (std::size_t i = 0; i < members; ++i) expect_all_of(i);
}

TEST_P(ChangingGroupsTest, LoseNothingAndKeepTheOrderOfLargeSamples) {
  for (const char* mask : {"data, name", "*"}) change_the_masks_of_the_first_six(mask, 200'000);
  for (std::size_t i = 0; i < members; ++i) expect_all_of(i);
}

TEST_P(MulticastTest, IsOffWhereItWasSwitchedOff) {
  writer_ = nullptr;
  publisher_ = nullptr;
  writer_ = open({.multicast = Multicast::off});
  publisher_ = std::make_unique<Publisher>(*writer_, own_id());
  add("*", false);
  add("*", false);
  serve();
  publish();
  EXPECT_EQ(state_of(1), "alone: multicast is off by option");
}

TEST_P(MulticastTest, IsNotForReadersOfThisHost) {
  publisher_ = nullptr;
  writer_ = open();
  publisher_ = std::make_unique<Publisher>(*writer_, own_id());
  add("*", false);
  add("*", false);
  serve();
  publish();
  EXPECT_EQ(state_of(2), "alone: it is on this host");
}

TEST(MulticastLinks, AreThoseThatCarryItWell) {
  constexpr unsigned ethernet = IFF_UP | IFF_BROADCAST | IFF_MULTICAST;
  const auto automatic = [](unsigned flags, bool wireless) {
    return why_no_multicast("eth0", flags, wireless, Multicast::automatic);
  };
  EXPECT_EQ(automatic(ethernet, false), "");
  EXPECT_EQ(automatic(ethernet, true), "interface eth0 is wireless");
  EXPECT_EQ(automatic(IFF_UP | IFF_BROADCAST, false), "interface eth0 has no multicast");
  EXPECT_EQ(automatic(ethernet | IFF_POINTOPOINT, false), "interface eth0 leads to one host only");
  EXPECT_EQ(automatic(ethernet | IFF_LOOPBACK, false), "it is on this host");
  EXPECT_EQ(why_no_multicast("eth0", ethernet, false, Multicast::off), "multicast is off by option");
  EXPECT_EQ(why_no_multicast("eth0", ethernet | IFF_LOOPBACK, true, Multicast::everywhere), "");
}

TEST(MulticastLinks, LeaveOutTheLoopback) {
  const auto links = multicast_links(Multicast::automatic);
  const auto loopback = std::ranges::find(links, "lo", &MulticastLink::interface);
  ASSERT_NE(loopback, links.end());
  EXPECT_EQ(loopback->refusal, "it is on this host");
}

}  // namespace
}  // namespace sft::udp
