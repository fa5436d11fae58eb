// Subscribers that change their selections while samples are sent, over every transport.
#include <algorithm>
#include <atomic>
#include <cstring>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/cut_reference.h"
#include "tests/support/encoded.h"
#include "tests/support/isolated_host.h"
#include "tests/support/pace.h"
#include "tests/support/test_seed.h"
#include "tests/system/scan_cloud.h"

namespace sft::test {
namespace {

/// Returns a cloud with one row of points of one byte each, with `number` as its stamp.
PointCloud2 row(std::int32_t number) {
  PointCloud2 cloud;
  cloud.header.stamp.sec = number;
  cloud.height = 1;
  cloud.width = cloud.row_step = 1000;
  cloud.point_step = 1;
  for (std::uint32_t i = 0; i < cloud.width; ++i)
    cloud.data.push_back(static_cast<std::uint8_t>(7 * i + static_cast<std::uint32_t>(number)));
  return cloud;
}

/// Returns true if the sample has the bytes that its selection takes from the row. The stamp of the sample is
/// the number of the row.
bool has_what_it_names(const DynamicSample& sample) {
  if (sample.selection() == nullptr || sample.selection()->parts().size() != 1) return false;
  const Selection::Range part = sample.selection()->parts()[0].columns;
  const PointCloud2 whole = row(sample.view()["header"]["stamp"]["sec"].as<std::int32_t>().value());
  const DynamicView data = sample.view()["data"];
  const std::uint32_t size = part.size_of(whole.width);
  if (data.size() != size) return false;
  for (std::uint32_t i = 0; i < size; ++i)
    if (data[i].as<std::uint8_t>() != whole.data[part.begin + i * part.step]) return false;
  return true;
}

/// Random selections from a cloud of scan_cloud(): fields, channels, rows and columns, and conditions that
/// are often fulfilled.
class AnySelection {
 public:
  std::string next() {
    const bool is_of_data = random_() % 5 != 0;
    std::string text =
        one_of({"header.stamp", "height, width", "fields, is_dense", "header.frame_id, row_step"});
    if (is_of_data)
      text += ", data" + one_of({"", "{x}", "{y,ring}", "{ring,lacking}", "{x,y,ring}"}) + window();
    return text +
           one_of({"", "", " @ every 2nd", " @ header.stamp.sec > 3", " @ changed(header.stamp.sec) 2"});
  }

 private:
  std::string one_of(std::vector<std::string> texts) { return std::move(texts[random_() % texts.size()]); }
  std::string window() {
    if (random_() % 3 == 0) return "";
    return "[rows " + range(4) + ", columns " + range(50) + "]";
  }
  /// Returns a range that is not empty.
  std::string range(std::uint64_t count) {
    const std::uint64_t begin = random_() % count, size = 1 + random_() % count;
    return std::to_string(begin) + ":" + std::to_string(begin + size) + ":" +
           std::to_string(1 + random_() % 3);
  }

  Random random_{test_seed()};
};

/// Returns true if the sample equals, byte for byte, the part that the reference implementation cuts from
/// the cloud with the number of the sample.
bool is_what_it_names(const DynamicSample& sample) {
  PointCloud2 expected = scan_cloud(sample.info().sequence);
  if (sample.selection() != nullptr) {
    for (const Selection::Part& part : sample.selection()->parts())
      expected = cut_reference::cut(expected, part);
  }
  const std::vector<std::byte> bytes =
      Encoded(type_support<PointCloud2>().type(), &expected, sample.mask()).bytes();
  constexpr std::size_t encapsulation = 4;
  const std::span<const std::byte> cdr = sample.cdr();
  return cdr.size() == encapsulation + bytes.size() &&
         std::memcmp(cdr.data() + encapsulation, bytes.data(), bytes.size()) == 0;
}

class SelectionChangeTest : public PubSubTest {
 protected:
  static inline const SubscriberOptions deep{.reliability = Reliability::reliable, .depth = 200};

  DynamicType type() { return b.find_type("points", hang_timeout).value(); }

  Node a = open("a");
  Node b = open("b");
  Publisher<PointCloud2> pub =
      a.publisher<PointCloud2>("points", {.reliability = Reliability::reliable}).value();
};

TEST_P(SelectionChangeTest, AWindowThatMovesGivesEachSampleThePartThatItNames) {
  const auto window = [](int begin) {
    return "header.stamp, data[" + std::to_string(begin) + ":" + std::to_string(begin + 10) + "]";
  };
  auto sub = b.subscriber("points", type(), window(0), deep).value();
  expect_served(pub, 1);
  for (std::int32_t round = 1; round <= 50; ++round) {
    ASSERT_TRUE(sub.set_selection(window(3 * round)));
    pub.publish(row(round));
    ASSERT_TRUE(sub.wait(hang_timeout));
    while (const DynamicSample sample = sub.take()) {
      ASSERT_TRUE(has_what_it_names(sample)) << "round " << round;
      ASSERT_EQ(sample.view()["data"].size().value(), 10U);
    }
  }
  EXPECT_EQ(sub.status().lost, 0U);
}

TEST_P(SelectionChangeTest, ASampleOfACompiledSubscriberNamesItsPart) {
  SubscriberOptions options = deep;
  options.selection = "data[:10]";
  auto sub = b.subscriber<PointCloud2, F::header.stamp | F::data>("points", options).value();
  const auto none = sub.take();
  EXPECT_EQ(none.selection(), nullptr);
  expect_served(pub, 1);
  const auto begin_of_the_next = [&]() -> std::uint32_t {
    EXPECT_TRUE(sub.wait(hang_timeout));
    const auto sample = sub.take();
    if (!sample || sample.selection() == nullptr || sample.selection()->parts().size() != 1) return 0;
    EXPECT_TRUE(sample.selection()->mask().contains(F::header.stamp | F::data));
    const std::uint32_t begin = sample.selection()->parts()[0].columns.begin;
    EXPECT_EQ(sample->data()[0], row(sample->header().stamp().sec()).data[begin]);
    return begin;
  };
  ASSERT_EQ(pub.publish(row(1)), PublishStatus::ok);
  EXPECT_EQ(begin_of_the_next(), 0U);
  ASSERT_TRUE(sub.set_selection("data[500:510]"));
  std::int32_t number = 1;
  EXPECT_TRUE(eventually([&] {
    EXPECT_EQ(pub.publish(row(++number)), PublishStatus::ok);
    return begin_of_the_next() == 500;
  }));
}

// The reader is reliable and misses no sample, although a different selection is in force for each sample.
TEST_P(SelectionChangeTest, AThousandSelectionsInTrafficAreEachDecodedAsWhatTheyName) {
  SCOPED_TRACE(how_to_repeat());
  Random random{test_seed()};
  const auto any_window = [&random] {
    const std::uint64_t begin = random() % 990, step = 1 + random() % 7;
    return "header.stamp, data[" + std::to_string(begin) + ":" + std::to_string(begin + 1 + random() % 100) +
           ":" + std::to_string(step) + "]";
  };
  auto sub = b.subscriber("points", type(), any_window(), deep).value();
  expect_served(pub, 1);
  std::atomic<std::uint32_t> published{0};
  std::optional<Ticker> traffic(std::in_place, 1ms, [&](std::uint32_t number) {
    EXPECT_EQ(pub.publish(row(static_cast<std::int32_t>(number))), PublishStatus::ok);
    published = number;
  });
  std::uint32_t taken = 0;
  const auto take_all = [&] {
    while (const DynamicSample sample = sub.take()) {
      ++taken;
      ASSERT_EQ(sample.info().sequence, taken);
      ASSERT_TRUE(has_what_it_names(sample)) << "sample " << taken;
    }
  };
  for (int change = 0; change < 1000 && !HasFatalFailure(); ++change) {
    ASSERT_TRUE(sub.set_selection(any_window()));
    ASSERT_TRUE(sub.wait(hang_timeout)) << "change " << change;
    take_all();
  }
  traffic.reset();
  EXPECT_TRUE(eventually([&] {
    take_all();
    return taken == published;
  }));
  EXPECT_GE(published, 1000U);
  EXPECT_EQ(sub.status().lost, 0U);
}

TEST_P(SelectionChangeTest, SelectionsOfAnyKindInTrafficAreEachDecodedAsWhatTheyName) {
  SCOPED_TRACE(how_to_repeat());
  AnySelection any;
  auto sub = b.subscriber("points", type(), any.next(), deep).value();
  expect_served(pub, 1);
  const Ticker traffic(
      1ms, [&](std::uint32_t number) { EXPECT_EQ(pub.publish(scan_cloud(number)), PublishStatus::ok); });
  std::uint64_t last = 0;
  for (int change = 0; change < 1000 && !HasFatalFailure(); ++change) {
    const std::string asked = any.next();
    ASSERT_TRUE(sub.set_selection(asked)) << asked;
    ASSERT_TRUE(sub.wait(hang_timeout)) << "change " << change << " to " << asked;
    while (const DynamicSample sample = sub.take()) {
      ASSERT_GT(sample.info().sequence, last);
      last = sample.info().sequence;
      ASSERT_TRUE(is_what_it_names(sample)) << "sample " << last << ", change " << change << " to " << asked;
    }
  }
  EXPECT_EQ(sub.status().lost, 0U);
}

INSTANTIATE_TEST_SUITE_P(Ways, SelectionChangeTest, ::testing::Values(Way::shm, Way::udp, Way::udp_sockets),
                         way_name);

}  // namespace
}  // namespace sft::test
