// Tests which readers of a publisher share a gate, and for which readers a sample counts as their first
// one.
#include "core/publish/gates.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <string>
#include <vector>

#include "tests/unit/core/publish/port_logs.h"

namespace sft::core::test {
namespace {

using sensor_msgs::msg::PointCloud2;

class GatesTest : public ::testing::Test {
 protected:
  Route route(EndpointId reader, const std::string& selection, std::uint32_t min_period_us = 0) const {
    Route route = network_route(reader, type);
    route.selection = type.closed(type.parse_selection(selection).value());
    route.min_period_us = min_period_us;
    return route;
  }
  /// Assigns gates to the routes, puts the routes in force, and returns them.
  std::vector<Route> serve(std::vector<Route> routes) {
    gates.give(routes);
    Serving serving;
    serving.network = routes;
    gates.open_for(serving);
    return routes;
  }
  bool passes(const Route& route, std::uint32_t width) {
    PointCloud2 cloud;
    cloud.width = width;
    gates.of(route)->consider(detail::FieldSource::of_message(&cloud), ++stamp_ns);
    gates.of(route)->made(detail::FieldSource::of_message(&cloud), stamp_ns);
    return route.gate->passes();
  }

  const TypeSupport& type = type_support<PointCloud2>();
  Gates gates{type};
  std::int64_t stamp_ns = 0;
};

TEST_F(GatesTest, ReadersThatWantTheSameShareAGate) {
  const auto routes =
      serve({route(1, "data @ width > 5"), route(2, "height @ width > 5"), route(3, "data @ width > 6"),
             route(4, "data @ width > 5", 1000), route(5, "data"), route(6, "data", 1000)});
  EXPECT_EQ(routes[0].gate, routes[1].gate) << "the fields do not matter";
  EXPECT_NE(routes[0].gate, routes[2].gate);
  EXPECT_NE(routes[0].gate, routes[3].gate);
  EXPECT_EQ(routes[4].gate, nullptr);
  EXPECT_NE(routes[5].gate, nullptr);
  EXPECT_EQ(routes[5].gate->id(), 0U) << "it has no conditions";
}

TEST_F(GatesTest, ASampleIsAChangeForAReaderThatComesOrAsksForSomethingElse) {
  Route one = serve({route(1, "data @ changed(width) 5")})[0];
  EXPECT_TRUE(passes(one, 0));
  EXPECT_FALSE(passes(one, 0));
  serve({route(1, "data @ changed(width) 5")});
  EXPECT_FALSE(passes(one, 0)) << "nothing is new";
  serve({route(1, "data @ changed(width) 5"), route(2, "height @ changed(width) 5")});
  EXPECT_TRUE(passes(one, 0)) << "for the second reader";
  EXPECT_FALSE(passes(one, 0));
  serve({route(1, "data[0:5] @ changed(width) 5"), route(2, "height @ changed(width) 5")});
  EXPECT_TRUE(passes(one, 0)) << "for the part";
  serve({route(2, "height @ changed(width) 5")});
  EXPECT_FALSE(passes(one, 0)) << "a reader that goes asks for nothing";
}

TEST_F(GatesTest, AComparisonRefusesTheFirstSampleOfEachReader) {
  Route one = serve({route(1, "data @ width > 5")})[0];
  EXPECT_FALSE(passes(one, 0));
  serve({route(1, "data @ width > 5"), route(2, "height @ width > 5")});
  EXPECT_FALSE(passes(one, 0));
  EXPECT_TRUE(passes(one, 6));
  serve({route(1, "data[0:5] @ width > 5"), route(2, "height @ width > 5")});
  EXPECT_FALSE(passes(one, 0));
}

TEST_F(GatesTest, OneThatNobodyAsksForGoesOnWithItsNumbersUntilThereAreManyOthers) {
  const auto serve_one = [&](int width) {
    gates.tidy();
    return serve({route(1, "data @ width > " + std::to_string(width))})[0].gate;
  };
  std::weak_ptr<const Gate> first = serve_one(0);
  std::vector<std::weak_ptr<const Gate>> others;
  for (int width = 1; width < 60; ++width) others.push_back(serve_one(width));
  EXPECT_FALSE(first.expired());
  for (int width = 60; width < 200; ++width) others.push_back(serve_one(width));
  EXPECT_TRUE(first.expired());
  EXPECT_FALSE(others.back().expired());
  EXPECT_LT(std::ranges::count_if(others, [](const auto& gate) { return !gate.expired(); }), 70);
}

TEST_F(GatesTest, NothingPassesBeforeTheRoutesAreInForce) {
  std::vector<Route> routes{route(1, "data @ width > 5")};
  gates.give(routes);
  EXPECT_FALSE(passes(routes[0], 6));
  serve(routes);
  EXPECT_FALSE(passes(routes[0], 0));
  EXPECT_TRUE(passes(routes[0], 6));
}

}  // namespace
}  // namespace sft::core::test
