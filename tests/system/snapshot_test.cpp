// node.snapshot() names every pair, its path and its mask. Its counts agree with each other, and with the
// samples that were published and received.
#include <algorithm>
#include <nlohmann/json.hpp>
#include <random>
#include <vector>

#include "tests/system/fixture.h"

namespace sft::test {
namespace {

class NodeSnapshotTest : public PubSubTest {
 protected:
  static constexpr std::size_t body_bytes_of_one_scalar = 4;

  template <class S>
  static std::uint64_t take_all(S& subscriber) {
    std::uint64_t taken = 0;
    while (subscriber.take()) ++taken;
    return taken;
  }
  /// Waits until every published sample is counted as received, lost or withheld.
  template <class S>
  void expect_all_accounted_for(S& subscriber, std::uint64_t published) {
    EXPECT_TRUE(eventually([&] {
      take_all(subscriber);
      const SubscriberStatus s = subscriber.status();
      return s.received + s.lost + s.withheld == published;
    })) << subscriber.status().received
        << " of " << published;
  }
  NodeSnapshot::Publisher published() { return a.snapshot().publishers.at(0); }
  NodeSnapshot::Publisher::Reader reader(const std::string& fields) {
    for (const NodeSnapshot::Publisher::Reader& r : published().readers) {
      if (r.fields == fields) return r;
    }
    return {};
  }
  void expect_sums(std::uint64_t samples) {
    const NodeSnapshot::Publisher p = published();
    EXPECT_EQ(p.published, samples);
    EXPECT_FALSE(p.readers.empty());
    std::uint64_t saved = 0;
    for (const NodeSnapshot::Publisher::Reader& r : p.readers) {
      EXPECT_EQ(r.published, samples) << r.fields;
      EXPECT_EQ(r.published, r.sent + r.withheld + r.dropped);
      saved += r.bytes_saved;
      EXPECT_TRUE(!in_shared_memory() || r.bytes_sent + r.bytes_saved == 0);
    }
    EXPECT_EQ(p.bytes_saved, saved);
  }
  std::size_t whole_body(const PointCloud2& message) {
    auto all = b.subscriber<PointCloud2>("whole").value();
    auto once = a.publisher<PointCloud2>("whole").value();
    EXPECT_TRUE(eventually([&] {
      once.publish(message);
      return all.wait(1ms);
    }));
    const auto sample = all.take();
    return sample.cdr().size() - 4;
  }

  Node a = open("a");
  Node b = open("b");
  Publisher<PointCloud2> pub = a.publisher<PointCloud2>("points").value();
};

TEST_P(NodeSnapshotTest, NamesPublishersSubscribersAndWhyTheyAreConnectedAsTheyAre) {
  auto sub = b.subscriber<PointCloud2, F::height | F::width>("points", {.max_rate_hz = 50}).value();
  auto rec = b.subscriber<PointCloud2, recorded>("other").value();
  expect_served(pub, 1);
  const NodeSnapshot here = a.snapshot();
  EXPECT_EQ(here.name, "a");
  EXPECT_FALSE(here.version.empty());
  ASSERT_EQ(here.publishers.size(), 1U);
  const NodeSnapshot::Publisher& p = here.publishers[0];
  EXPECT_EQ(p.topic, "points");
  EXPECT_EQ(p.type, "sensor_msgs::msg::PointCloud2");
  EXPECT_EQ(p.fields, in_shared_memory() ? "*" : "height, width");
  const NodeSnapshot::Publisher::Reader& r = p.readers.at(0);
  EXPECT_EQ(r.node, "b");
  EXPECT_EQ(r.fields, "height, width");
  EXPECT_EQ(r.max_rate_hz, 50);
  EXPECT_TRUE(r.served);
  EXPECT_EQ(r.transport, in_shared_memory() ? TransportKind::shm : TransportKind::udp);
  EXPECT_FALSE(r.reason.empty());
  const NodeSnapshot there = b.snapshot();
  ASSERT_EQ(there.subscribers.size(), 2U);
  EXPECT_EQ(there.subscribers[0].fields, "height, width");
  EXPECT_EQ(there.subscribers[0].max_rate_hz, 50);
  EXPECT_EQ(there.subscribers[0].writers.at(0).node, "a");
  EXPECT_EQ(there.subscribers[0].writers.at(0).id, p.id);
  EXPECT_TRUE(there.subscribers[1].recorded);
  EXPECT_EQ(there.subscribers[1].fields, "*");
  EXPECT_TRUE(there.subscribers[1].writers.empty());
}

TEST_P(NodeSnapshotTest, ForgetsWhatIsDestroyed) {
  {
    auto gone = a.subscriber<PointCloud2>("points").value();
    auto gone_too = a.publisher<PointCloud2>("points").value();
    EXPECT_EQ(a.snapshot().publishers.size(), 2U);
    EXPECT_EQ(a.snapshot().subscribers.size(), 1U);
  }
  EXPECT_EQ(a.snapshot().publishers.size(), 1U);
  EXPECT_TRUE(a.snapshot().subscribers.empty());
}

TEST_P(NodeSnapshotTest, OfWhatEachReaderAsksForItSaysWhatItCostAndWhatItSaved) {
  const PointCloud2 message = cloud(1, 5000);
  const std::size_t whole = whole_body(message);
  auto height = b.subscriber<PointCloud2, F::height>("points", {.depth = 1000}).value();
  auto all = b.subscriber<PointCloud2>("points", {.depth = 1000}).value();
  expect_served(pub, 2);
  constexpr std::uint64_t samples = 100;
  for (std::uint64_t i = 0; i < samples; ++i) pub.publish(message);
  expect_all_accounted_for(height, samples);
  expect_all_accounted_for(all, samples);
  expect_sums(samples);
  EXPECT_EQ(reader("height").sent, samples);
  EXPECT_EQ(reader("*").sent, samples);
  if (in_shared_memory()) return;
  EXPECT_EQ(reader("height").bytes_sent, samples * body_bytes_of_one_scalar);
  EXPECT_EQ(reader("height").bytes_saved, samples * (whole - body_bytes_of_one_scalar));
  EXPECT_EQ(reader("*").bytes_sent, samples * whole);
  EXPECT_EQ(reader("*").bytes_saved, 0U);
  EXPECT_GT(published().bytes_sent, reader("*").bytes_sent + reader("height").bytes_sent);
}

// No reader requests all fields, so that no sample is encoded whole.
TEST_P(NodeSnapshotTest, WhatIsSavedIsMeasuredWhereNothingIsEncodedWhole) {
  const PointCloud2 message = cloud(1, 5000);
  const std::size_t whole = whole_body(message);
  auto height = b.subscriber<PointCloud2, F::height>("points", {.depth = 1000}).value();
  expect_served(pub, 1);
  for (int i = 0; i < 10; ++i) pub.publish(message);
  expect_all_accounted_for(height, 10);
  expect_sums(10);
  if (in_shared_memory()) return;
  EXPECT_EQ(reader("height").bytes_saved, 10 * (whole - body_bytes_of_one_scalar));
}

TEST_P(NodeSnapshotTest, AReaderThatIsGoneStillHasSavedWhatItSaved) {
  std::optional sub = b.subscriber<PointCloud2, F::height>("points").value();
  expect_served(pub, 1);
  for (int i = 0; i < 10; ++i) pub.publish(cloud(1));
  const std::uint64_t saved = published().bytes_saved;
  EXPECT_EQ(saved == 0, in_shared_memory());
  sub.reset();
  ASSERT_TRUE(eventually([&] { return published().readers.empty(); }));
  pub.publish(cloud(1));
  EXPECT_EQ(published().bytes_saved, saved);
}

TEST_P(NodeSnapshotTest, WhatIsWithheldForARateIsNeitherSentNorDropped) {
  auto slow = b.subscriber<PointCloud2, F::height>("points", {.max_rate_hz = 20}).value();
  auto fast = b.subscriber<PointCloud2, F::width>("points", {.depth = 1000}).value();
  expect_served(pub, 2);
  std::uint64_t samples = 0;
  EXPECT_TRUE(eventually([&] {
    pub.publish(cloud(1));
    ++samples;
    take_all(slow);
    take_all(fast);
    return reader("height").sent >= 5;
  }));
  expect_all_accounted_for(fast, samples);
  expect_sums(samples);
  EXPECT_GT(reader("height").withheld, 0U);
  EXPECT_EQ(reader("height").withheld + reader("height").sent, samples);
  EXPECT_EQ(reader("width").sent, samples);
}

// Masks and rates change all the time while samples are published. Each sample counts once for each reader.
TEST_P(NodeSnapshotTest, CountsAgreeWhateverChangesMeanwhile) {
  std::mt19937 random(7);
  auto rec = b.subscriber<PointCloud2, recorded>(
                  "points", {.depth = 4000, .recording = {.learn_samples = 2, .narrow_after_samples = 3}})
                 .value();
  auto limited = b.subscriber<PointCloud2, F::height>("points", {.depth = 4000}).value();
  expect_served(pub, 2);
  constexpr std::uint64_t samples = 2000;
  const auto requests = [&] { return rec.status().requests + limited.status().requests; };
  const std::uint64_t requests_before = requests();
  for (std::uint64_t i = 0; i < samples; ++i) {
    pub.publish(cloud(1, 100));
    if (i % 50 == 0) {
      ASSERT_TRUE(limited.set_max_rate_hz(random() % 2 == 0 ? 0 : 1000));
      std::this_thread::yield();
    }
    while (const auto sample = rec.take()) {
      if (i / 100 % 2 == 0) (void)sample->height();
      if (i / 300 % 2 == 0) (void)sample->data();
    }
    take_all(limited);
  }
  expect_all_accounted_for(rec, samples);
  EXPECT_TRUE(eventually([&] { return requests() > requests_before; })) << "the test changed nothing";
  const NodeSnapshot::Publisher p = published();
  EXPECT_EQ(p.published, samples);
  EXPECT_EQ(p.readers.size(), 2U);
  for (const NodeSnapshot::Publisher::Reader& r : p.readers) {
    EXPECT_EQ(r.published, samples) << r.fields;
    EXPECT_EQ(r.sent + r.withheld + r.dropped, samples);
  }
  const SubscriberStatus heard = rec.status();
  EXPECT_EQ(heard.received + heard.lost, samples);
  EXPECT_EQ(heard.received, heard.writers.at(0).received);
  EXPECT_EQ(heard.lost, heard.writers.at(0).lost);
}

TEST_P(NodeSnapshotTest, WhatAFullQueuePushedOutIsDiscarded) {
  auto sub = b.subscriber<PointCloud2, F::height>("points", {.depth = 2}).value();
  auto watcher = b.subscriber<PointCloud2, F::height>("points", {.depth = 100}).value();
  expect_served(pub, 2);
  pub.publish(cloud(1));
  ASSERT_TRUE(sub.wait(hang_timeout));
  EXPECT_EQ(take_all(sub), 1U);
  for (int i = 0; i < 10; ++i) pub.publish(cloud(1));
  expect_all_accounted_for(watcher, 11);
  EXPECT_EQ(take_all(sub), 2U);
  const NodeSnapshot::Subscriber s = b.snapshot().subscribers.at(0);
  EXPECT_EQ(s.discarded, 8U);
  EXPECT_EQ(s.lost, 8U);
  EXPECT_EQ(s.received, 3U);
}

TEST_P(NodeSnapshotTest, MayBeTakenInCallbacks) {
  std::atomic<std::size_t> publishers{0};
  std::atomic<std::size_t> readers{0};
  auto other = a.publisher<PointCloud2>(
                    "other", {.on_event = [&](const Event&) { publishers = a.snapshot().publishers.size(); }})
                   .value();
  auto sub = a.subscriber<PointCloud2, F::height>("other", [&](const auto&) {
                readers = a.snapshot().publishers.at(1).readers.size();
              }).value();
  EXPECT_TRUE(eventually([&] {
    other.publish(cloud(1));
    return publishers == 2 && readers == 1;
  }));
}

TEST_P(NodeSnapshotTest, AsJsonItHasTheSameUnderStableNames) {
  warnings_expected = true;
  auto sub = b.subscriber<PointCloud2, F::height>("points").value();
  auto stranger = b.subscriber<PointCloud2, F::height>("points", {.reliability = reliable}).value();
  expect_served(pub, 1);
  const auto is_connected = [](const auto& writer) { return writer.connected; };
  // A reader reports to its publisher that it is connected before its own status shows this.
  ASSERT_TRUE(eventually([&] {
    return pub.status().readers.size() == 2 && stranger.status().writers.size() == 1 &&
           std::ranges::any_of(sub.status().writers, is_connected);
  }));
  pub.publish(cloud(1));
  const NodeSnapshot snapshot = a.snapshot();
  const auto json = nlohmann::json::parse(to_json(snapshot));
  EXPECT_EQ(json.at("node").at("name"), "a");
  EXPECT_EQ(json.at("shm").at("ready"), in_shared_memory());
  EXPECT_EQ(json.at("udp").at("refused").at("malformed"), 0);
  EXPECT_EQ(json.at("control").at("refused").at("ignored"), 0);
  const auto& p = json.at("publishers").at(0);
  EXPECT_EQ(p.at("published"), 1);
  EXPECT_EQ(p.at("qos").at("reliability"), "best_effort");
  EXPECT_EQ(p.at("id").get<std::string>().size(), 16U);
  bool matched = false, refused = false;
  for (const auto& r : p.at("readers")) {
    matched |= r.at("served") == true && r.at("transport") == (in_shared_memory() ? "shm" : "udp") &&
               r.at("fields") == "height" && r.at("sent") == 1 && r.at("incompatible_policy").is_null();
    refused |= r.at("transport").is_null() && r.at("incompatible_policy") == "reliability";
  }
  EXPECT_TRUE(matched) << p.dump(2);
  EXPECT_TRUE(refused) << p.dump(2);
  const auto there = nlohmann::json::parse(to_json(b.snapshot(), -1));
  const auto& writer = there.at("subscribers").at(0).at("writers").at(0);
  EXPECT_EQ(writer.at("node"), "a");
  EXPECT_EQ(writer.at("connected"), true);
  EXPECT_EQ(writer.at("transport"), in_shared_memory() ? "shm" : "udp");
  EXPECT_EQ(there.at("subscribers").at(1).at("writers").at(0).at("matched"), false);
  EXPECT_TRUE(there.at("subscribers").at(1).at("writers").at(0).at("transport").is_null());
}

TEST(SnapshotJsonTest, NothingTravelsFromAWriterThatMatchesUntilItIsConnected) {
  NodeSnapshot snapshot;
  snapshot.subscribers.resize(1);
  auto& writers = snapshot.subscribers[0].writers;
  writers = {{.id = 7, .node = "a", .matched = true},
             {.id = 8, .node = "a", .matched = true, .connected = true}};
  const auto json = nlohmann::json::parse(to_json(snapshot)).at("subscribers").at(0).at("writers");
  EXPECT_TRUE(json.at(0).at("transport").is_null());
  EXPECT_EQ(json.at(1).at("transport"), "shm");
}

INSTANTIATE_TEST_SUITE_P(Ways, NodeSnapshotTest, ::testing::Values(Way::shm, Way::udp, Way::udp_sockets),
                         way_name);

}  // namespace
}  // namespace sft::test
