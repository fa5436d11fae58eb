// The system's clock is set while programs run: by NTP, by hand, or by decades on a robot without a battery.
// Samples go on, and times keep their length. The program has a clock of its own, which the test sets.
#include <gtest/gtest.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <sft/sft.h>
#include <array>
#include <atomic>
#include <cstdint>
#include <ctime>
#include <std_srvs/srv/SetBool.hpp>
#include <thread>

#include "tests/system/fixture.h"

namespace {
std::atomic<std::int64_t> set_by_s{0};
}

/// Takes the place of the function of the C library in this program and in the libraries that it uses.
extern "C" int clock_gettime(clockid_t clock, timespec* time) noexcept {
  const auto result = static_cast<int>(syscall(SYS_clock_gettime, clock, time));
  if (clock == CLOCK_REALTIME) time->tv_sec += set_by_s.load();
  return result;
}

namespace sft::test {
namespace {

class ClockSetTest : public PubSubTest {
 protected:
  ClockSetTest() { set_by_s = 0; }
  ~ClockSetTest() override { set_by_s = 0; }

  static constexpr std::int64_t hour = 3600, decades = 20LL * 365 * 24 * 3600;
  static constexpr std::array<std::int64_t, 5> settings{hour, -hour, decades, -decades, 0};

  /// Returns by how many seconds the stamp differs from the clock of the host.
  static double seconds_ahead(const SampleInfo& info) {
    timespec now{};
    syscall(SYS_clock_gettime, CLOCK_REALTIME, &now);
    const auto stamp = std::chrono::duration<double>(info.source_stamp.time_since_epoch());
    return stamp.count() - static_cast<double>(now.tv_sec);
  }

  /// Publishes the same cloud until the subscriber, which takes some samples only, has received three of them
  /// under each setting of the clock.
  template <class P, class S>
  void expect_samples_go_on(P& pub, S& sub) {
    for (const std::int64_t setting : settings) {
      set_by_s = setting;
      for (int i = 0; i < 3; ++i) {
        EXPECT_TRUE(eventually([&] {
          pub.publish(PointCloud2{.height = 1});
          return static_cast<bool>(sub.take());
        })) << setting;
      }
    }
  }

  Node source_ = open("source");
  Node app_ = open("app");
};

INSTANTIATE_TEST_SUITE_P(Ways, ClockSetTest, ::testing::Values(Way::shm, Way::udp, Way::udp_sockets),
                         way_name);

TEST_P(ClockSetTest, SamplesArriveAndNoDeadlineIsMissed) {
  auto pub =
      source_.publisher<PointCloud2>("points", {.reliability = reliable, .deadline = hang_timeout}).value();
  auto sub =
      app_.subscriber<PointCloud2>("points", {.reliability = reliable, .deadline = hang_timeout}).value();
  expect_served(pub, 1);
  std::uint32_t number = 0;
  for (const std::int64_t setting : settings) {
    set_by_s = setting;
    for (int i = 0; i < 40; ++i) {
      pub.publish(cloud(++number));
      ASSERT_TRUE(sub.wait(hang_timeout)) << number;
      const auto sample = sub.take();
      ASSERT_TRUE(sample);
      EXPECT_EQ(sample->height(), number);
      EXPECT_NEAR(seconds_ahead(sample.info()), static_cast<double>(setting), 120.0) << "the stamps jump";
    }
  }
  const SubscriberStatus status = sub.status();
  EXPECT_EQ(status.lost, 0U);
  ASSERT_EQ(status.writers.size(), 1U);
  EXPECT_EQ(status.writers[0].deadlines_missed, 0U);
  EXPECT_EQ(pub.status().deadlines_missed, 0U);
}

TEST_P(ClockSetTest, RatesGoOn) {
  auto pub = source_.publisher<PointCloud2>("points").value();
  auto sub = app_.subscriber<PointCloud2>("points", {.max_rate_hz = 20}).value();
  expect_served(pub, 1);
  expect_samples_go_on(pub, sub);
}

TEST_P(ClockSetTest, ConditionsGoOn) {
  auto pub = source_.publisher<PointCloud2>("points").value();
  auto sub =
      app_.subscriber<PointCloud2>("points", {.selection = "@ changed(height) or every 0.05 s"}).value();
  expect_served(pub, 1);
  expect_samples_go_on(pub, sub);
}

TEST_P(ClockSetTest, WaitsTakeAsLongAsTheyShould) {
  auto silent = app_.subscriber<PointCloud2>("silent").value();
  for (const std::int64_t setting : settings) {
    const auto begin = std::chrono::steady_clock::now();
    std::jthread setter([setting] { set_by_s = setting; });
    EXPECT_FALSE(silent.wait(100ms));
    EXPECT_GE(std::chrono::steady_clock::now() - begin, 100ms) << setting;
    EXPECT_LT(std::chrono::steady_clock::now() - begin, hang_timeout) << setting;
  }
}

TEST_P(ClockSetTest, ServicesAnswer) {
  using std_srvs::srv::SetBool;
  const auto answer = [](const SetBool::Request& request) {
    return SetBool::Response{.success = request.data};
  };
  const auto server = Service<SetBool>::open(source_, "lights", answer).value();
  auto client = Client<SetBool>::open(app_, "lights").value();
  for (const std::int64_t setting : settings) {
    set_by_s = setting;
    const auto response = client.call({.data = true}, hang_timeout);
    ASSERT_TRUE(response) << response.error().message;
    EXPECT_TRUE(response->success);
  }
}

TEST_P(ClockSetTest, WhoComesLaterGetsWhatIsRetained) {
  auto pub =
      source_.publisher<PointCloud2>("points", {.reliability = reliable, .durability = transient_local})
          .value();
  pub.publish(cloud(7));
  for (const std::int64_t setting : settings) {
    set_by_s = setting;
    auto late =
        app_.subscriber<PointCloud2>("points", {.reliability = reliable, .durability = transient_local})
            .value();
    ASSERT_TRUE(late.wait(hang_timeout)) << setting;
    const auto sample = late.take();
    EXPECT_EQ(sample->height(), 7U);
  }
}

}  // namespace
}  // namespace sft::test
