// Subscribers with conditions for the samples that they need, over every transport.
#include <gmock/gmock.h>

#include <nav_msgs/msg/Odometry.hpp>
#include <numeric>
#include <vector>

#include "tests/support/isolated_host.h"
#include "tests/system/fixture.h"

namespace sft::test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class SelectionNodesTest : public PubSubTest {
 protected:
  using Numbers = std::vector<std::uint32_t>;

  DynamicType type() { return b.find_type("points", hang_timeout).value(); }
  /// Publishes clouds with these heights. The tests identify samples by their heights.
  void publish(const Numbers& heights) {
    for (const std::uint32_t height : heights) ASSERT_EQ(pub.publish(cloud(height)), PublishStatus::ok);
  }
  /// Takes all samples up to the one with the height `last`, which must arrive. Returns the heights of the
  /// samples.
  template <class S>
  static Numbers until(S& sub, std::uint32_t last) {
    Numbers heights;
    while (heights.empty() || heights.back() != last) {
      if (!sub.wait(hang_timeout)) {
        ADD_FAILURE() << "sample " << last << " did not come";
        break;
      }
      while (const DynamicSample sample = sub.take())
        heights.push_back(sample.view()["height"].template as<std::uint32_t>().value());
    }
    return heights;
  }
  PublisherStatus::Reader reader() { return pub.status().readers.at(0); }

  Node a = open("a");
  Node b = open("b");
  Publisher<PointCloud2> pub =
      a.publisher<PointCloud2>("points", {.reliability = Reliability::reliable}).value();
};

const SubscriberOptions deep{.reliability = Reliability::reliable, .depth = 200};

TEST_P(SelectionNodesTest, OnlySamplesThatFulfilTheConditionsComeAlsoAtFirst) {
  auto sub = b.subscriber("points", type(), "height @ height > 100 and height < 200", deep).value();
  expect_served(pub, 1);
  publish({1, 2, 101, 3, 199, 200, 150});
  EXPECT_THAT(until(sub, 150), ElementsAre(101, 199, 150));
  EXPECT_EQ(sub.status().withheld, 2U) << "behind the first one that came";
  EXPECT_EQ(sub.status().lost, 0U);
  EXPECT_EQ(reader().sent, 3U);
  EXPECT_EQ(reader().withheld, 4U);
}

TEST_P(SelectionNodesTest, WhatIsWithheldTakesNoPlaceInTheQueue) {
  auto sub = b.subscriber("points", type(), "height @ height >= 100", {.depth = 2}).value();
  expect_served(pub, 1);
  Numbers quiet(90);
  std::iota(quiet.begin(), quiet.end(), 1);
  publish({1});
  publish({100});
  publish(quiet);
  EXPECT_THAT(until(sub, 100), ElementsAre(100));
  EXPECT_EQ(sub.status().lost, 0U);
  publish({101});
  EXPECT_THAT(until(sub, 101), ElementsAre(101));
  EXPECT_EQ(sub.status().withheld, 90U);
  EXPECT_EQ(sub.status().lost, 0U);
}

TEST_P(SelectionNodesTest, WhatTheQueueLosesIsToldFromWhatWasWithheld) {
  auto sub = b.subscriber("points", type(), "height @ height >= 100", {.depth = 2}).value();
  expect_served(pub, 1);
  publish({200});
  EXPECT_THAT(until(sub, 200), ElementsAre(200));
  publish({2, 100, 3, 4, 101, 5, 102, 6, 103});
  // In shared memory the reader counts discarded samples when it takes the next sample.
  ASSERT_TRUE(in_shared_memory() || eventually([&] { return sub.status().discarded == 2; }));
  EXPECT_THAT(until(sub, 103), ElementsAre(102, 103));
  EXPECT_EQ(sub.status().lost, 2U);
  EXPECT_EQ(sub.status().withheld, 5U);
}

TEST_P(SelectionNodesTest, AChangeIsSentAndNothingWithinItsDeadband) {
  auto sub = b.subscriber("points", type(), "height @ changed 10 %", deep).value();
  expect_served(pub, 1);
  publish({100, 101, 109, 110, 111, 122, 121, 100, 99, 200});
  EXPECT_THAT(until(sub, 200), ElementsAre(100, 111, 99, 200));
  EXPECT_EQ(sub.status().withheld, 6U);
}

TEST_P(SelectionNodesTest, EachReaderHasItsConditionsAndOneWithoutGetsEverySample) {
  const DynamicType type = this->type();
  auto even = b.subscriber("points", type, "height @ every 2nd", deep).value();
  auto large = b.subscriber("points", type, "height @ height > 4", deep).value();
  auto all = b.subscriber("points", type, "height", deep).value();
  expect_served(pub, 3);
  publish({1, 2, 3, 4, 5, 6, 7});
  EXPECT_THAT(until(even, 7), ElementsAre(1, 3, 5, 7));
  EXPECT_THAT(until(large, 7), ElementsAre(5, 6, 7));
  EXPECT_THAT(until(all, 7), ElementsAre(1, 2, 3, 4, 5, 6, 7));
}

TEST_P(SelectionNodesTest, TheConditionsOfACompiledSubscriberStandInItsOptions) {
  SubscriberOptions options = deep;
  options.selection = "@ height > 4";
  auto sub = b.subscriber<PointCloud2, F::height>("points", options).value();
  expect_served(pub, 1);
  publish({1, 2, 5, 3, 6});
  Numbers heights;
  while (heights.empty() || heights.back() != 6) {
    ASSERT_TRUE(sub.wait(hang_timeout));
    while (const auto sample = sub.take()) heights.push_back(sample->height());
  }
  EXPECT_THAT(heights, ElementsAre(5, 6));
  EXPECT_THAT(sub.set_selection("width @ every 2nd").error().message,
              HasSubstr("names fields that the subscriber does not declare: width"));
  options.selection = "height @ width >";
  EXPECT_THAT((b.subscriber<PointCloud2, F::height>("points", options).error().message),
              HasSubstr("column 17"));
}

// Each reader has its own condition: "height >= 1", "height >= 2", and so on.
TEST_P(SelectionNodesTest, SixtyFourReadersWithSixtyFourConditionsGetWhatTheyAskedFor) {
  constexpr std::uint32_t readers = 64;
  const DynamicType type = this->type();
  std::vector<DynamicSubscriber> subs;
  for (std::uint32_t least = 1; least <= readers; ++least)
    subs.push_back(b.subscriber("points", type, "height @ height >= " + std::to_string(least), deep).value());
  expect_served(pub, readers);
  Numbers heights(readers + 1);
  std::iota(heights.begin(), heights.end(), 0);
  publish({readers + 1});
  publish(heights);
  for (std::uint32_t least = 1; least <= readers; ++least) {
    Numbers expected{readers + 1};
    for (std::uint32_t height = least; height <= readers; ++height) expected.push_back(height);
    EXPECT_EQ(until(subs[least - 1], readers), expected);
    EXPECT_EQ(subs[least - 1].status().withheld, least);
    EXPECT_EQ(subs[least - 1].status().lost, 0U);
  }
}

TEST_P(SelectionNodesTest, LoansAndEncodedSamplesPassTheSameConditions) {
  auto sub = b.subscriber("points", type(), "height @ height > 4", deep).value();
  expect_served(pub, 1);
  publish({7});
  for (const std::uint32_t height : {3U, 5U, 4U, 6U}) {
    Loan<PointCloud2> loan = pub.loan(cloud(height)).value();
    EXPECT_EQ(std::move(loan).publish(), PublishStatus::ok);
  }
  EXPECT_THAT(until(sub, 6), ElementsAre(7, 5, 6));
  EXPECT_EQ(sub.status().withheld, 2U);
}

TEST_P(SelectionNodesTest, AnotherSelectionTakesTheOthersPlaceAndItsFirstSampleFulfilsItToo) {
  auto sub = b.subscriber("points", type(), "height @ height > 100", deep).value();
  expect_served(pub, 1);
  publish({1, 2, 101});
  EXPECT_THAT(until(sub, 101), ElementsAre(101));
  ASSERT_TRUE(sub.set_selection("height, width @ height > 200"));
  ASSERT_TRUE(eventually([&] { return reader().selection.mask().size() == 2; }));
  publish({150, 151, 201});
  EXPECT_THAT(until(sub, 201), ElementsAre(201));
  ASSERT_TRUE(sub.set_selection("height"));
  ASSERT_TRUE(eventually([&] { return reader().selection.is_mask(); }));
  publish({1, 2});
  EXPECT_THAT(until(sub, 2), ElementsAre(1, 2));
  EXPECT_EQ(sub.status().lost, 0U);
  EXPECT_EQ(sub.requirements().text, "height");
}

TEST_P(SelectionNodesTest, ChannelsThatACloudLacksAreNamed) {
  auto sub = b.subscriber("points", type(), "height, data{y,ring,x}", deep).value();
  expect_served(pub, 1);
  publish({1});
  ASSERT_TRUE(sub.wait(hang_timeout));
  const DynamicSample sample = sub.take();
  EXPECT_THAT(sample.missing_channels(), ::testing::UnorderedElementsAre("ring", "x", "y"))
      << "fields[1] is called y, but has no elements";
}

TEST_P(SelectionNodesTest, ACompiledSampleNamesMissingChannelsToo) {
  SubscriberOptions options = deep;
  options.selection = "data{y,ring}";
  auto sub = b.subscriber<PointCloud2>("points", options).value();
  EXPECT_TRUE(Sample<PointCloud2>().missing_channels().empty());
  expect_served(pub, 1);
  publish({1});
  ASSERT_TRUE(sub.wait(hang_timeout));
  const auto sample = sub.take();
  EXPECT_THAT(sample.missing_channels(), ::testing::UnorderedElementsAre("ring", "y"));
}

TEST_P(SelectionNodesTest, ALateReaderGetsThePartsOfTheRetainedSamplesThatFulfilItsConditions) {
  auto retaining = a.publisher<PointCloud2>("retained", {.reliability = Reliability::reliable,
                                                         .durability = Durability::transient_local,
                                                         .history_depth = 3})
                       .value();
  const auto publish_each = [&](const Numbers& stamps) {
    for (const std::uint32_t stamp : stamps) {
      PointCloud2 row = cloud(stamp);
      row.height = row.point_step = 1;
      row.width = row.row_step = static_cast<std::uint32_t>(row.data.size());
      ASSERT_EQ(retaining.publish(row), PublishStatus::ok);
    }
  };
  publish_each({1, 2, 3, 4, 5});
  SubscriberOptions options = deep;
  options.durability = Durability::transient_local;
  const DynamicType type = b.find_type("retained", hang_timeout).value();
  auto sub =
      b.subscriber("retained", type, "header.stamp, data[::100] @ header.stamp.sec > 3", options).value();
  expect_served(retaining, 1);
  const auto stamps_until = [&](std::int32_t last) {
    std::vector<std::int32_t> stamps;
    while ((stamps.empty() || stamps.back() != last) && sub.wait(hang_timeout)) {
      while (const DynamicSample sample = sub.take()) {
        stamps.push_back(sample.view()["header"]["stamp"]["sec"].as<std::int32_t>().value());
        const DynamicView data = sample.view()["data"];
        EXPECT_EQ(data.size().value(), 10U) << stamps.back();
        EXPECT_EQ(data[1].as<std::uint8_t>(), cloud(static_cast<std::uint32_t>(stamps.back())).data[100]);
      }
    }
    return stamps;
  };
  EXPECT_THAT(stamps_until(5), ElementsAre(4, 5));
  publish_each({1, 2, 101});
  EXPECT_THAT(stamps_until(101), ElementsAre(101));
  EXPECT_EQ(sub.status().lost, 0U);
}

TEST_P(SelectionNodesTest, ALateReaderWhoseConditionsNoRetainedSampleFulfilsGetsTheFirstLaterOneThatDoes) {
  auto retaining = a.publisher<PointCloud2>("retained", {.reliability = Reliability::reliable,
                                                         .durability = Durability::transient_local,
                                                         .history_depth = 3})
                       .value();
  const auto publish_each = [&](const Numbers& heights) {
    for (const std::uint32_t height : heights) ASSERT_EQ(retaining.publish(cloud(height)), PublishStatus::ok);
  };
  publish_each({1, 2, 3, 4, 5});
  SubscriberOptions options = deep;
  options.durability = Durability::transient_local;
  const DynamicType type = b.find_type("retained", hang_timeout).value();
  auto sub = b.subscriber("retained", type, "height @ height > 100", options).value();
  expect_served(retaining, 1);
  publish_each({7, 101, 8, 102});
  EXPECT_THAT(until(sub, 102), ElementsAre(101, 102));
  EXPECT_EQ(sub.status().lost, 0U);
}

TEST_P(SelectionNodesTest, AWrongSelectionChangesNothing) {
  auto sub = b.subscriber("points", type(), "height", deep).value();
  auto recorder = b.subscriber("points", type(), recorded).value();
  expect_served(pub, 2);
  EXPECT_THAT(sub.set_selection("height @ weight > 1").error().message, HasSubstr("column 10"));
  EXPECT_THAT(recorder.set_selection("height").error().message, HasSubstr("records its fields"));
  const Selection foreign{FieldMask(nav_msgs::msg::Odometry::Field::header)};
  EXPECT_THAT(sub.set_selection(foreign).error().message, HasSubstr("for another type than"));
  publish({7});
  EXPECT_THAT(until(sub, 7), ElementsAre(7));
}

INSTANTIATE_TEST_SUITE_P(Ways, SelectionNodesTest, ::testing::Values(Way::shm, Way::udp, Way::udp_sockets),
                         way_name);

}  // namespace
}  // namespace sft::test
