// A publisher of clouds, and subscribers on other hosts that request channels, ranges and windows. Each
// subscriber gets exactly the requested part, and each part is sent only once over the network.
#include <gtest/gtest.h>

#include <sft/sft.h>
#include <algorithm>
#include <array>
#include <atomic>
#include <cstdio>
#include <memory>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <string>
#include <vector>

#include "tests/support/eventually.h"
#include "tests/support/isolated_host.h"
#include "tests/support/pace.h"
#include "tests/system/node_process.h"
#include "tools/hosts/interface_counters.h"
#include "tools/hosts/network.h"

namespace sft::test {
namespace {

using sensor_msgs::msg::PointCloud2;
using namespace std::chrono_literals;

constexpr std::uint32_t points = 4000, point_bytes = 32;
constexpr double whole_bytes = double{points} * point_bytes;

struct Cloudcast {
  std::atomic<bool> failed{false};
  std::atomic<std::uint32_t> wanted{0};  ///< the number of samples to publish
  std::atomic<std::uint32_t> count{0};
  std::atomic<std::size_t> served{0}, in_groups{0};
  std::atomic<std::uint64_t> link_bytes{0};  ///< the bytes that the publisher's host has sent
};

struct Received {
  std::atomic<bool> failed{false};
  std::atomic<bool> wrong{false};  ///< true: a sample did not match its selection, or was out of order
  std::atomic<std::uint32_t> selection{0};  ///< the index of the selection that the subscriber should request
  std::atomic<std::uint32_t> count{0}, last{0};
  std::atomic<std::uint64_t> lost{0};
  std::atomic<std::uint32_t> named{0};  ///< the index of the selection of the last sample
};

std::uint8_t byte_at(std::uint32_t number, std::size_t at) {
  return static_cast<std::uint8_t>(number * 7 + at * 31 + at / 256);
}

PointCloud2 cloud_number(std::uint32_t number) {
  PointCloud2 cloud;
  cloud.header.stamp.sec = static_cast<std::int32_t>(number);
  cloud.height = 1;
  cloud.width = points;
  cloud.fields = {
      {"x", 0, 7, 1}, {"y", 4, 7, 1}, {"z", 8, 7, 1}, {"intensity", 12, 7, 1}, {"ring", 16, 4, 1}};
  cloud.point_step = point_bytes;
  cloud.row_step = point_bytes * points;
  cloud.data.resize(std::size_t{point_bytes} * points);
  for (std::size_t i = 0; i < cloud.data.size(); ++i) cloud.data[i] = byte_at(number, i);
  return cloud;
}

void publish_numbered(Node& node, Cloudcast& cast) {
  auto publisher = node.publisher<PointCloud2>("points", {.reliability = Reliability::reliable}).value();
  Pace pace(2ms);
  for (;; pace.await_turn()) {
    std::size_t served = 0, in_groups = 0;
    for (const PublisherStatus::Reader& reader : publisher.status().readers) {
      served += reader.served ? 1 : 0;
      in_groups += reader.multicast.starts_with("group ") && !reader.multicast.ends_with("more") ? 1 : 0;
    }
    cast.served = served;
    cast.in_groups = in_groups;
    cast.link_bytes = hosts::interface_bytes(hosts::host_interface).value_or(hosts::InterfaceBytes{}).sent;
    if (cast.count >= cast.wanted) continue;
    publisher.publish(cloud_number(cast.count + 1));
    ++cast.count;
  }
}

/// Returns the bytes of `data` that the selection takes from the cloud with that number.
std::vector<std::uint8_t> part_of_cloud(std::uint32_t number, const Selection::Part* part) {
  std::vector<std::uint8_t> bytes;
  for (std::uint32_t point = 0; point < points; ++point) {
    const auto takes = [&](std::uint32_t offset, std::uint32_t count) {
      for (std::uint32_t i = 0; i < count; ++i)
        bytes.push_back(byte_at(number, std::size_t{point} * point_bytes + offset + i));
    };
    if (part != nullptr) {
      const Selection::Range& range = part->columns;
      if (point < range.begin || point >= range.end || (point - range.begin) % range.step != 0) continue;
    }
    if (part == nullptr || part->channels.empty()) {
      takes(0, point_bytes);
      continue;
    }
    constexpr std::array<std::pair<const char*, std::pair<std::uint32_t, std::uint32_t>>, 5> all{
        {{"x", {0, 4}}, {"y", {4, 4}}, {"z", {8, 4}}, {"intensity", {12, 4}}, {"ring", {16, 2}}}};
    for (const auto& [name, place] : all) {
      if (std::ranges::find(part->channels, name) != part->channels.end()) takes(place.first, place.second);
    }
  }
  return bytes;
}

/// Returns true if the sample was made from the cloud with that number, and contains exactly the part that
/// its selection names.
bool is_what_it_names(const DynamicSample& sample, std::uint32_t number) {
  const Selection* const named = sample.selection();
  if (named == nullptr) return false;
  const DynamicView data = sample.view()["data"];
  if (!data) return named->parts().empty();
  const Selection::Part* const part = named->parts().empty() ? nullptr : &named->parts()[0];
  const std::vector<std::uint8_t> expected = part_of_cloud(number, part);
  if (data.size().value_or(0) != expected.size()) return false;
  for (std::size_t i = 0; i < expected.size(); i += 13) {
    if (data[i].as<std::uint8_t>().value() != expected[i]) return false;
  }
  return true;
}

/// Subscribes with one selection at a time: the selection whose index is in Received::selection.
auto subscribe_in_turn(std::vector<std::string> selections) {
  return [selections = std::move(selections)](Node& node, Received& received) {
    const DynamicType type = node.find_type("points", hang_timeout).value();
    std::vector<Selection> asked;
    for (const std::string& text : selections) {
      const TypeSupport& support = type.support();
      asked.push_back(support.closed(support.parse_selection(text).value()));
    }
    std::uint32_t current = received.selection;
    auto subscriber = node.subscriber("points", type, selections.at(current),
                                      {.reliability = Reliability::reliable, .depth = 5000})
                          .value();
    for (;;) {
      if (received.selection != current) {
        current = received.selection;
        if (!subscriber.set_selection(selections.at(current))) received.failed = true;
      }
      subscriber.wait(5ms);
      while (const DynamicSample sample = subscriber.take()) {
        const auto number = static_cast<std::uint32_t>(sample.info().sequence);
        if (number != received.last + 1 && received.last != 0) received.wrong = true;
        if (!is_what_it_names(sample, number)) received.wrong = true;
        const auto name = std::ranges::find(asked, *sample.selection());
        received.named = static_cast<std::uint32_t>(name - asked.begin());
        received.last = number;
        ++received.count;
      }
      received.lost = subscriber.status().lost;
    }
  };
}

/// Requests all of the selections at the same time, with a subscriber for each.
auto subscribe_together(std::vector<std::string> selections) {
  return [selections = std::move(selections)](Node& node, Received& received) {
    const DynamicType type = node.find_type("points", hang_timeout).value();
    std::vector<DynamicSubscriber> subscribers;
    std::vector<Selection> asked;
    for (const std::string& text : selections) {
      asked.push_back(type.support().closed(type.support().parse_selection(text).value()));
      subscribers.push_back(
          node.subscriber("points", type, text, {.reliability = Reliability::reliable, .depth = 5000})
              .value());
    }
    std::vector<std::uint32_t> last(selections.size());
    for (;;) {
      std::uint64_t lost = 0;
      for (std::size_t i = 0; i < subscribers.size(); ++i) {
        subscribers[i].wait(1ms);
        while (const DynamicSample sample = subscribers[i].take()) {
          const auto number = static_cast<std::uint32_t>(sample.info().sequence);
          const bool is_next = last[i] == 0 || number == last[i] + 1;
          if (!is_next || !is_what_it_names(sample, number) || *sample.selection() != asked[i])
            received.wrong = true;
          last[i] = number;
          if (i == 0) ++received.count;
        }
        lost += subscribers[i].status().lost;
      }
      received.lost = lost;
      received.last = std::ranges::min(last);
    }
  };
}

class PartHostsTest : public testing::Test {
 protected:
  using Subscriber = NodeProcessWith<Received>;

  void SetUp() override {
    if (!isolation_refusal().empty()) GTEST_SKIP() << isolation_refusal();
    auto made = hosts::EmulatedNetwork::create(8);
    if (!made) GTEST_SKIP() << made.error().message;
    network_ = std::make_unique<hosts::EmulatedNetwork>(std::move(*made));
  }
  static NodeOptions options() { return {.transport = TransportChoice::udp}; }

  void open_publisher() {
    publisher_ = std::make_unique<NodeProcessWith<Cloudcast>>(network_->host(0), options(), publish_numbered);
  }
  void open_all(const std::vector<std::vector<std::string>>& selections) {
    open_publisher();
    for (const auto& some : selections) {
      subscribers_.push_back(std::make_unique<Subscriber>(network_->host(subscribers_.size() + 1), options(),
                                                          subscribe_in_turn(some)));
    }
    ASSERT_TRUE(eventually([&] { return cast().served == selections.size(); }, hang_timeout));
  }
  Cloudcast& cast() { return publisher_->report(); }
  Received& received(std::size_t subscriber) { return subscribers_[subscriber]->report(); }
  /// Publishes `count` more samples, and waits until all subscribers have received the last one.
  bool publish_more(std::uint32_t count) {
    cast().wanted += count;
    return eventually(
        [&] {
          return std::ranges::all_of(subscribers_,
                                     [&](const auto& one) { return one->report().last == cast().wanted; });
        },
        hang_timeout);
  }
  /// Publishes until at least `readers` readers are in multicast groups.
  bool publish_until_in_groups(std::size_t readers) {
    return eventually([&] { return cast().in_groups >= readers || (publish_more(5), false); }, hang_timeout);
  }
  /// Returns the bytes on the link per sample. Each sample is published only when every subscriber has
  /// received the previous one, so that no reader lags behind its group.
  double bytes_of_a_sample() {
    constexpr std::uint32_t samples = 20;
    EXPECT_TRUE(publish_more(1));
    const std::uint64_t before = cast().link_bytes;
    for (std::uint32_t i = 0; i < samples; ++i) EXPECT_TRUE(publish_more(1));
    return static_cast<double>(cast().link_bytes - before) / samples;
  }
  /// Measures until the multicast groups have settled, and a sample takes at most `bytes` bytes on the
  /// link.
  testing::AssertionResult sends_at_most(double bytes) {
    double least = bytes_of_a_sample();
    const auto is_within = [&] { return least <= bytes || (least = bytes_of_a_sample()) <= bytes; };
    const bool settles = eventually(is_within, hang_timeout);
    std::printf("%.0f bytes on the link for each sample, of at most %.0f\n", least, bytes);
    return settles ? testing::AssertionSuccess() : testing::AssertionFailure() << least << " bytes";
  }
  void expect_all_is_right() {
    for (std::size_t i = 0; i < subscribers_.size(); ++i) {
      EXPECT_FALSE(received(i).failed) << i;
      EXPECT_FALSE(received(i).wrong) << i;
      EXPECT_EQ(received(i).lost, 0U) << i;
      EXPECT_EQ(received(i).count, cast().wanted) << i;
    }
  }

  std::unique_ptr<hosts::EmulatedNetwork> network_;
  std::unique_ptr<NodeProcessWith<Cloudcast>> publisher_;
  std::vector<std::unique_ptr<Subscriber>> subscribers_;
};

TEST_F(PartHostsTest, FourHostsThatAskForTheSameChannelsCostOneCopyOfThem) {
  open_all({{"data{x,y,z}"}, {"data{x,y,z}"}, {"data{x,y,z}"}, {"data{x,y,z}"}});
  ASSERT_TRUE(publish_until_in_groups(4));
  EXPECT_TRUE(sends_at_most(1.2 * 12 * points));
  expect_all_is_right();
}

TEST_F(PartHostsTest, WholePartsAndScalarsAreServedBesideEachOther) {
  open_all({{"*"}, {"*"}, {"data{x,y,z}"}, {"data{x,y,z}"}, {"data[::4]"}, {"height, width"}});
  ASSERT_TRUE(publish_until_in_groups(5));
  EXPECT_TRUE(sends_at_most(1.2 * whole_bytes));
  expect_all_is_right();
}

/// The hosts request windows that largely overlap. The whole field is sent once to all hosts, and each host
/// cuts its window out of the field.
TEST_F(PartHostsTest, WindowsThatOverlapAreCutOutOfOneCopyOfTheWholeField) {
  open_all({{"data[:3900]"}, {"data[50:3950]"}, {"data[100:]"}, {"data{x,y,z,intensity,ring}"}});
  ASSERT_TRUE(publish_until_in_groups(4));
  EXPECT_TRUE(sends_at_most(1.2 * whole_bytes));
  expect_all_is_right();
}

TEST_F(PartHostsTest, TheSubscribersOfANodeCutTheirPartsOutOfOneCopy) {
  open_publisher();
  subscribers_.push_back(std::make_unique<Subscriber>(
      network_->host(1), options(),
      subscribe_together({"data[:3900]", "data[100:]", "data{x,y,z}", "height, width, data{ring}"})));
  ASSERT_TRUE(eventually([&] { return cast().served == 4; }, hang_timeout));
  EXPECT_TRUE(sends_at_most(1.2 * whole_bytes));
  expect_all_is_right();
}

TEST_F(PartHostsTest, ASubscriberThatChangesItsPartLosesNothingAndNeitherDoOthers) {
  const std::vector<std::string> in_turn{"data{x,y,z}", "data{intensity}", "*", "data[::3]", "data[10:4000]"};
  open_all({in_turn, {"data{x,y,z}"}, {"data[5:]"}, {"*"}});
  ASSERT_TRUE(publish_until_in_groups(4));
  for (std::uint32_t round = 1; round <= 15; ++round) {
    const auto next = static_cast<std::uint32_t>(round % in_turn.size());
    received(0).selection = next;
    ASSERT_TRUE(
        eventually([&] { return received(0).named == next || (publish_more(2), false); }, hang_timeout))
        << "round " << round;
  }
  EXPECT_TRUE(publish_until_in_groups(4)) << "it has settled";
  EXPECT_TRUE(publish_more(20));
  expect_all_is_right();
}

}  // namespace
}  // namespace sft::test
