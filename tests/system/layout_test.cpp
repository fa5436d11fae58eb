// Subscribers request parts of a field whose layout rule the user has defined, over every transport. The
// publisher is compiled with the type. The subscriber knows the type from the description that the
// publisher sends.
#include <gmock/gmock.h>

#include <layout_msgs/msg/Cells.hpp>
#include <layout_msgs/msg/HeightMap.hpp>
#include <layout_msgs/msg/LargeArray.hpp>
#include <memory>
#include <string>
#include <vector>

#include "sft/msg_text.h"
#include "tests/support/isolated_host.h"
#include "tests/system/fixture.h"

namespace sft::test {
namespace {

using layout_msgs::msg::Cells;
using layout_msgs::msg::HeightMap;
using layout_msgs::msg::LargeArray;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

class LayoutNodesTest : public PubSubTest {
 protected:
  static constexpr std::uint32_t rows = 5, columns = 6;

  DynamicType type() { return b.find_type("map", hang_timeout).value(); }

  /// Returns a map in which the height of a cell is 100 * row + column + `number`.
  static HeightMap map(std::uint32_t number = 0) {
    HeightMap m;
    m.rows = rows;
    m.columns = columns;
    m.resolution = 0.5F;
    m.origin.position.x = 10;
    m.origin.orientation.w = 1;
    for (std::uint32_t row = 0; row < rows; ++row) {
      for (std::uint32_t column = 0; column < columns; ++column)
        m.heights.push_back(static_cast<float>(1000 * number + 100 * row + column));
    }
    m.note = "yard";
    return m;
  }
  static std::vector<float> heights_of(const DynamicSample& sample) {
    const DynamicView heights = sample.view()["heights"];
    std::vector<float> all;
    for (std::size_t i = 0; i < heights.size().value(); ++i) all.push_back(heights[i].as<float>().value());
    return all;
  }
  static std::uint32_t number(const DynamicSample& sample, const char* field) {
    return sample.view().find(field).as<std::uint32_t>().value();
  }
  DynamicSample next(auto& sub) {
    EXPECT_TRUE(sub.wait(hang_timeout));
    return sub.take();
  }

  Node a = open("a");
  Node b = open("b");
  Publisher<HeightMap> pub = a.publisher<HeightMap>("map", {.reliability = Reliability::reliable}).value();
};

TEST_P(LayoutNodesTest, AStructThatIsTooLargeForTheStackIsCopiedToTheHeap) {
  auto frames = a.publisher<LargeArray>("frames", {.reliability = Reliability::reliable}).value();
  auto sub = b.subscriber<LargeArray>("frames", {.reliability = Reliability::reliable}).value();
  expect_served(frames, 1);
  const auto sent = std::make_unique<LargeArray>();
  sent->seq = 7;
  sent->data.back() = 9;
  ASSERT_EQ(frames.publish(*sent), PublishStatus::ok);
  ASSERT_TRUE(sub.wait(hang_timeout));
  const auto sample = sub.take();
  const auto copy = std::make_unique<LargeArray>();
  copy->data.front() = 1;
  EXPECT_TRUE(sample.to_owned(*copy));
  EXPECT_TRUE(*copy == *sent);
  const auto partial = std::make_unique<Partial<LargeArray>>();
  EXPECT_TRUE(sample.to_partial(*partial));
  EXPECT_TRUE(partial->value == *sent);
  EXPECT_TRUE(partial->mask == sample.mask());
  EXPECT_FALSE(Sample<LargeArray>().to_owned(*copy));
}

const SubscriberOptions reliable{.reliability = Reliability::reliable, .depth = 20};

TEST_P(LayoutNodesTest, ADynamicSubscriberGetsTheRowsAndColumnsThatItNames) {
  auto cells = a.publisher<Cells>("cells", {.reliability = Reliability::reliable}).value();
  auto sub = b.subscriber("cells", b.find_type("cells", hang_timeout).value(), "cells[rows 2:4, columns ::2]",
                          reliable)
                 .value();
  expect_served(cells, 1);
  Cells whole;
  whole.rows = rows;
  whole.columns = columns;
  const std::vector<float> heights = map().heights;
  whole.cells.assign(heights.begin(), heights.end());
  ASSERT_EQ(cells.publish(whole), PublishStatus::ok);
  const DynamicSample sample = next(sub);
  const DynamicView part = sample.view()["cells"];
  std::vector<double> kept;
  for (std::size_t i = 0; i < part.size().value(); ++i) kept.push_back(part[i].as<double>().value());
  EXPECT_THAT(kept, ElementsAre(200, 202, 204, 300, 302, 304));
  EXPECT_EQ(number(sample, "rows"), 2U);
  EXPECT_EQ(number(sample, "columns"), 3U);
  EXPECT_FALSE(sample.selection()->parts().empty());
}

TEST_P(LayoutNodesTest, APartIsAMapThatSaysWhereItLies) {
  auto sub = b.subscriber("map", type(), "heights[rows 1:5:2, columns 2::2], note", reliable).value();
  expect_served(pub, 1);
  ASSERT_EQ(pub.publish(map()), PublishStatus::ok);
  const DynamicSample sample = next(sub);
  EXPECT_THAT(heights_of(sample), ElementsAre(102, 104, 302, 304));
  EXPECT_EQ(number(sample, "rows"), 2U);
  EXPECT_EQ(number(sample, "columns"), 2U);
  EXPECT_EQ(sample.view().find("resolution").as<float>(), 1.0F);
  EXPECT_EQ(sample.view().find("origin.position.x").as<double>(), 10 + 2 * 0.5);
  EXPECT_EQ(sample.view().find("origin.position.y").as<double>(), 1 * 0.5);
  EXPECT_EQ(sample.view().find("note").as<std::string_view>(), "yard");
}

TEST_P(LayoutNodesTest, ACompiledSubscriberAsksForAPartInItsOptions) {
  SubscriberOptions options = reliable;
  options.selection = "heights[rows 4, columns 5]";
  auto sub = b.subscriber<HeightMap, HeightMap::Field::heights>("map", options).value();
  expect_served(pub, 1);
  ASSERT_EQ(pub.publish(map()), PublishStatus::ok);
  ASSERT_TRUE(sub.wait(hang_timeout));
  const auto sample = sub.take();
  EXPECT_THAT(sample->heights(), ElementsAre(405));
}

TEST_P(LayoutNodesTest, AWindowMovesOverTheMap) {
  const auto window = [](std::uint32_t row) {
    return "heights[rows " + std::to_string(row) + ", columns 1:3]";
  };
  auto sub = b.subscriber("map", type(), window(0), reliable).value();
  expect_served(pub, 1);
  for (std::uint32_t round = 0; round < 20; ++round) {
    ASSERT_TRUE(sub.set_selection(window(round % rows)));
    ASSERT_EQ(pub.publish(map(round)), PublishStatus::ok);
    const DynamicSample sample = next(sub);
    ASSERT_NE(sample.selection(), nullptr);
    const std::uint32_t row = sample.selection()->parts()[0].rows.begin;
    const float first = static_cast<float>(1000 * round + 100 * row + 1);
    ASSERT_THAT(heights_of(sample), ElementsAre(first, first + 1));
  }
}

TEST_P(LayoutNodesTest, ASubscriberWithoutTheRuleGetsWholeFieldsAndIsToldWhyItGetsNoParts) {
  std::string text = to_msg(type()).value();
  const std::size_t begin = text.find(" @sft_layout");
  ASSERT_NE(begin, std::string::npos);
  text.erase(begin, text.find('\n', begin) - begin);
  const DynamicType plain = from_msg("layout_msgs/HeightMap", text).value();
  ASSERT_EQ(plain.hash(), type().hash());
  warnings_expected = true;
  auto sub = b.subscriber("map", plain, "heights[:3]", reliable).value();
  ASSERT_TRUE(eventually([&] {
    const auto readers = pub.status().readers;
    return readers.size() == 1 && readers[0].reason.find("another layout rule") != std::string::npos;
  }));
  EXPECT_FALSE(pub.status().readers[0].served);
  EXPECT_THAT(pub.status().readers[0].reason, HasSubstr("the part of heights"));
  ASSERT_TRUE(sub.set_selection("heights"));
  expect_served(pub, 1);
  ASSERT_EQ(pub.publish(map()), PublishStatus::ok);
  EXPECT_EQ(heights_of(next(sub)), map().heights);
}

INSTANTIATE_TEST_SUITE_P(Ways, LayoutNodesTest, ::testing::Values(Way::shm, Way::udp, Way::udp_sockets),
                         way_name);

}  // namespace
}  // namespace sft::test
