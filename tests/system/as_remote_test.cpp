// A subscriber in shared memory with `as_remote` gets the same bytes as a subscriber on another host.
#include <gmock/gmock.h>

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "tests/system/scan_cloud.h"

namespace sft::test {
namespace {

constexpr std::uint64_t samples = 13;

struct Got {
  std::uint64_t sequence = 0;
  std::string fields;
  std::optional<Selection> selection;
  std::vector<std::string> missing;
  std::vector<std::byte> cdr;
};

class SameCopyTest : public ::testing::TestWithParam<const char*> {
 protected:
  SameCopyTest() { warnings_expected = false; }
  static Node open(const std::string& name, TransportChoice transport) {
    NodeOptions options = node_options(Way::udp, name);
    options.transport = transport;
    return Node::open(options).value();
  }
  DynamicSubscriber subscribe(Node& node, bool as_remote) const {
    SubscriberOptions options{.reliability = Reliability::reliable, .depth = 100};
    options.recording.as_remote = as_remote;
    return node.subscriber("points", node.find_type("points", hang_timeout).value(), GetParam(), options)
        .value();
  }
  /// Takes all samples up to the last published one. The last sample passes all conditions of these tests.
  static std::vector<Got> take_all(DynamicSubscriber& subscriber) {
    std::vector<Got> all;
    while ((all.empty() || all.back().sequence < samples) && subscriber.wait(hang_timeout)) {
      while (const DynamicSample sample = subscriber.take()) {
        Got& got = all.emplace_back();
        got.sequence = sample.info().sequence;
        got.fields = sample.type().support().format_mask(sample.mask());
        if (sample.selection() != nullptr) got.selection = *sample.selection();
        got.missing = sample.missing_channels();
        std::ranges::sort(got.missing);
        got.cdr.assign(sample.cdr().begin(), sample.cdr().end());
      }
    }
    return all;
  }

  Node a = open("a", TransportChoice::automatic);
  Node here = open("here", TransportChoice::shm);
  Node there = open("there", TransportChoice::udp);
  Publisher<PointCloud2> pub =
      a.publisher<PointCloud2>("points", {.reliability = Reliability::reliable}).value();
};

TEST_P(SameCopyTest, SharedMemoryGivesWhatComesByUdp) {
  DynamicSubscriber by_memory = subscribe(here, true), by_udp = subscribe(there, false);
  ASSERT_TRUE(eventually([&] {
    const auto readers = pub.status().readers;
    const auto is_served_by = [&](TransportKind kind) {
      return std::ranges::any_of(readers, [&](const auto& r) { return r.served && r.transport == kind; });
    };
    return is_served_by(TransportKind::shm) && is_served_by(TransportKind::udp);
  }));
  for (std::uint64_t number = 1; number <= samples; ++number)
    ASSERT_EQ(pub.publish(scan_cloud(number)), PublishStatus::ok);
  const std::vector<Got> local = take_all(by_memory), remote = take_all(by_udp);
  ASSERT_EQ(local.size(), remote.size());
  for (std::size_t i = 0; i < local.size(); ++i) {
    EXPECT_EQ(local[i].sequence, remote[i].sequence);
    EXPECT_EQ(local[i].fields, remote[i].fields);
    EXPECT_EQ(local[i].selection, remote[i].selection);
    EXPECT_EQ(local[i].missing, remote[i].missing);
    EXPECT_EQ(local[i].cdr, remote[i].cdr) << "of sample " << local[i].sequence;
  }
  const SubscriberStatus status = by_memory.status(), other = by_udp.status();
  EXPECT_EQ(status.received, other.received);
  EXPECT_EQ(status.withheld, other.withheld);
  EXPECT_EQ(status.lost, 0U);
  EXPECT_EQ(other.lost, 0U);
}

INSTANTIATE_TEST_SUITE_P(Of, SameCopyTest,
                         ::testing::Values("*", "height, width, fields", "height, data{x,y}",
                                           "header.stamp, data{ring,intensity}[rows 1:3, columns ::4]",
                                           "data[columns 7:], width @ header.stamp.sec > 4", "* @ every 3rd",
                                           "data{y} @ header.stamp.sec > 12 or every 3rd"),
                         [](const auto& param) { return "Selection" + std::to_string(param.index); });

}  // namespace
}  // namespace sft::test
