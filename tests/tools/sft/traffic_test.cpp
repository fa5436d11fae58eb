// The rates that `sft top` shows. They are computed from the last two reports of each publisher.
#include "tools/sft/traffic.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

namespace sft::tool {
namespace {

using namespace std::chrono_literals;

constexpr std::uint64_t lidar = 7, camera = 8;

class TrafficTest : public testing::Test {
 protected:
  /// Makes the publisher's node report the publisher's progress. The reports of other publishers stay
  /// unchanged.
  void report(std::uint64_t publisher, std::uint64_t samples, std::uint64_t bytes) {
    const auto known = std::ranges::find(domain.publishers, publisher, &DomainSnapshot::Endpoint::id);
    DomainSnapshot::Endpoint& endpoint =
        known == domain.publishers.end() ? domain.publishers.emplace_back() : *known;
    endpoint.id = publisher;
    endpoint.progress = DomainSnapshot::Progress{samples, bytes};
  }
  /// Advances the time. The tool checks every 100 ms.
  void pass(std::chrono::milliseconds time) {
    for (const auto end = now + time; now < end;) traffic.note(domain, now += 100ms);
  }
  std::string rate(std::uint64_t publisher) const {
    const auto rate = traffic.of(publisher, now);
    return rate ? std::to_string(std::lround(rate->samples_per_s)) + " Hz, " +
                      std::to_string(std::lround(rate->bytes_per_s)) + " B/s"
                : "not known";
  }

  DomainSnapshot domain;
  Traffic traffic;
  Traffic::Clock::time_point now{1h};
};

TEST_F(TrafficTest, ARateIsKnownOnceAPublisherHasReportedItsProgressTwice) {
  pass(1s);
  EXPECT_EQ(rate(lidar), "not known");
  report(lidar, 100, 5000);
  pass(500ms);
  EXPECT_EQ(rate(lidar), "not known");
  report(lidar, 110, 5500);
  pass(100ms);
  EXPECT_EQ(rate(lidar), "20 Hz, 1000 B/s");
  EXPECT_EQ(rate(camera), "not known");
}

TEST_F(TrafficTest, ARateIsThatOfTheTimeBetweenTheTwoLastReports) {
  for (const std::uint64_t samples : {0, 10, 30}) {
    report(lidar, samples, 0);
    pass(500ms);
  }
  EXPECT_EQ(rate(lidar), "40 Hz, 0 B/s");
}

TEST_F(TrafficTest, APublisherThatFellSilentHasNoRateAnyMoreAndOthersKeepTheirs) {
  for (std::uint64_t i = 0; i < 3; ++i) {
    report(lidar, 100 * i, 0);
    report(camera, 10 * i, 0);
    pass(1s);
  }
  EXPECT_EQ(rate(lidar), "100 Hz, 0 B/s");
  for (std::uint64_t i = 3; i < 9; ++i) {
    report(camera, 10 * i, 0);
    pass(1s);
  }
  EXPECT_EQ(rate(lidar), "0 Hz, 0 B/s");
  EXPECT_EQ(rate(camera), "10 Hz, 0 B/s");
  for (const std::uint64_t samples : {300, 400}) {
    report(lidar, samples, 0);
    pass(1s);
  }
  EXPECT_EQ(rate(lidar), "100 Hz, 0 B/s") << "it sends again";
}

TEST_F(TrafficTest, APublisherThatHasLeftIsForgotten) {
  for (const std::uint64_t samples : {0, 100}) {
    report(lidar, samples, 0);
    pass(1s);
  }
  domain.publishers.clear();
  pass(100ms);
  EXPECT_EQ(rate(lidar), "not known");
  report(lidar, 200, 0);
  pass(100ms);
  EXPECT_EQ(rate(lidar), "not known");
}

}  // namespace
}  // namespace sft::tool
