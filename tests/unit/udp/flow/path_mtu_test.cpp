#include "udp_transport/flow/path_mtu.h"

#include <gtest/gtest.h>

#include <utility>
#include <vector>

namespace sft::udp {
namespace {

using namespace std::chrono_literals;

constexpr std::size_t headers = 28, shortest = 548;
constexpr std::size_t payload(std::size_t mtu) { return mtu - headers; }

/// A path that carries datagrams of at most `takes` bytes, and a writer that gets a report every 50 ms.
class Path {
 public:
  explicit Path(std::size_t kernel_says, std::size_t takes)
      : takes_(payload(takes)), mtu_(headers, shortest, payload(kernel_says)) {}

  void use_for(PathMtu::Time::duration time) {
    for (const auto end = now_ + time; now_ < end; now_ += 50ms) {
      const std::size_t before = mtu_.datagram_bytes();
      if (before > takes_ || mtu_.is_uncertain())
        before <= takes_ ? mtu_.arrived(mtu_.datagram_bytes(), now_) : mtu_.lost(mtu_.datagram_bytes(), now_);
      mtu_.look_after(now_);
      if (mtu_.datagram_bytes() != before) lengths_.push_back(mtu_.datagram_bytes() + headers);
    }
  }
  void takes(std::size_t mtu) { takes_ = payload(mtu); }
  PathMtu& mtu() { return mtu_; }
  std::vector<std::size_t> take_lengths() { return std::exchange(lengths_, {}); }

 private:
  std::size_t takes_;
  PathMtu mtu_;
  PathMtu::Time now_{1h};
  std::vector<std::size_t> lengths_;
};

TEST(PathMtuTest, IsWhatTheKernelSaysAsLongAsThatArrives) {
  Path path(9000, 9000);
  path.use_for(1h);
  EXPECT_TRUE(path.take_lengths().empty());
  EXPECT_EQ(path.mtu().datagram_bytes(), payload(9000));
  EXPECT_FALSE(path.mtu().is_uncertain());
  path.mtu().kernel_says(payload(1400));
  EXPECT_EQ(path.mtu().datagram_bytes(), payload(1400));
  path.mtu().kernel_says(payload(9000));
  EXPECT_EQ(path.mtu().datagram_bytes(), payload(9000));
}

TEST(PathMtuTest, ShrinksWhereLongDatagramsVanishAndThenFindsHowLongTheyMayBe) {
  Path path(9000, 1500);
  path.use_for(250ms);
  EXPECT_EQ(path.take_lengths(), (std::vector<std::size_t>{1280}));
  path.use_for(20s);
  EXPECT_EQ(path.take_lengths(), (std::vector<std::size_t>{1400, 1450, 1492, 1500, 4352, 1500}));
  EXPECT_TRUE(path.mtu().is_uncertain());
}

TEST(PathMtuTest, TriesMoreEverMoreSeldomWhereThatIsInVain) {
  Path path(1500, 1400);
  path.use_for(20s);
  path.take_lengths();
  EXPECT_EQ(path.mtu().datagram_bytes(), payload(1400));
  path.use_for(1h);
  const std::size_t tries = path.take_lengths().size() / 2;
  EXPECT_GE(tries, 6U);
  EXPECT_LE(tries, 14U);
  EXPECT_EQ(path.mtu().datagram_bytes(), payload(1400));
}

TEST(PathMtuTest, GrowsAgainWhenThePathDoes) {
  Path path(9000, 1400);
  path.use_for(10h);
  EXPECT_EQ(path.mtu().datagram_bytes(), payload(1400));
  path.takes(9000);
  path.use_for(11min);
  EXPECT_EQ(path.mtu().datagram_bytes(), payload(9000));
  EXPECT_FALSE(path.mtu().is_uncertain());
}

TEST(PathMtuTest, ShrinksToWhatEveryPathTakesWhereNothingElseArrives) {
  Path path(1500, 600);
  path.use_for(1s);
  EXPECT_EQ(path.take_lengths(), (std::vector<std::size_t>{1280, shortest + headers}));
  PathMtu ipv6(48, 1232, 1452);
  for (int i = 0; i < 100; ++i) ipv6.lost(ipv6.datagram_bytes(), PathMtu::Time{1h} + i * 50ms);
  EXPECT_EQ(ipv6.datagram_bytes(), 1232U);
}

TEST(PathMtuTest, FindsHowLongTheyMayBeWhereEvenUsualOnesVanish) {
  Path path(1500, 1200);
  path.use_for(20s);
  EXPECT_EQ(path.take_lengths(), (std::vector<std::size_t>{1280, shortest + headers, 1000, 1200}));
  EXPECT_EQ(path.mtu().limited_to(), payload(1200));
}

TEST(PathMtuTest, IsNotTakenInByLossOfAllLengths) {
  PathMtu mtu(headers, shortest, payload(1500));
  PathMtu::Time now{1h};
  for (int i = 0; i < 10'000; ++i, now += 50ms)
    i % 5 == 4 ? mtu.arrived(mtu.datagram_bytes(), now) : mtu.lost(mtu.datagram_bytes(), now);
  EXPECT_EQ(mtu.datagram_bytes(), payload(1500));
}

/// If the round trip is long, a reader reports the same loss several times before a repeated datagram can
/// arrive.
TEST(PathMtuTest, WaitsForAtLeastARoundTrip) {
  PathMtu mtu(headers, shortest, payload(1500));
  const PathMtu::Time now{1h};
  for (int i = 0; i < 100; ++i) mtu.lost(mtu.datagram_bytes(), now + i * 1ms);
  EXPECT_EQ(mtu.datagram_bytes(), payload(1500));
  mtu.lost(mtu.datagram_bytes(), now + PathMtu::timeout);
  EXPECT_EQ(mtu.datagram_bytes(), payload(1280));
}

TEST(PathMtuTest, ForgetsWhatItFoundOnAnotherWay) {
  Path path(1500, 1400);
  path.use_for(10s);
  EXPECT_EQ(path.mtu().datagram_bytes(), payload(1400));
  path.mtu().kernel_says(payload(9000));
  EXPECT_EQ(path.mtu().datagram_bytes(), payload(9000));
  path.take_lengths();
  path.use_for(250ms);
  EXPECT_EQ(path.take_lengths(), std::vector<std::size_t>{1280}) << "1400 has not arrived on this one";
}

TEST(PathMtuTest, TriesMoreSoonAgainOnAnotherWay) {
  Path path(1500, 1400);
  path.use_for(10h);
  path.mtu().kernel_says(payload(1480));
  path.use_for(5s);
  path.take_lengths();
  path.use_for(21s);
  EXPECT_EQ(path.take_lengths(), (std::vector<std::size_t>{1450, 1400}));
}

TEST(PathMtuTest, CountsNoLossesOfAnotherWay) {
  PathMtu mtu(headers, shortest, payload(9000));
  PathMtu::Time now{1h};
  for (int i = 1; i < PathMtu::losses_max; ++i, now += 100ms) mtu.lost(mtu.datagram_bytes(), now);
  mtu.kernel_says(payload(1500));
  EXPECT_FALSE(mtu.is_uncertain());
  mtu.lost(mtu.datagram_bytes(), now);
  EXPECT_EQ(mtu.datagram_bytes(), payload(1500));
}

TEST(PathMtuTest, ForgetsNothingWhereTheKernelSaysTheSameAgain) {
  Path path(1500, 1400);
  path.use_for(10s);
  path.mtu().kernel_says(payload(1500));
  EXPECT_EQ(path.mtu().datagram_bytes(), payload(1400));
}

TEST(PathMtuTest, IsNotShorterThanWhatEveryPathTakesWhateverTheKernelSays) {
  PathMtu mtu(headers, shortest, 100);
  EXPECT_EQ(mtu.datagram_bytes(), shortest);
  mtu.kernel_says(payload(1500));
  mtu.kernel_says(100);
  EXPECT_EQ(mtu.datagram_bytes(), shortest);
}

TEST(PathMtuTest, ShrinksAlsoWhereLongDatagramsArrivedBeforeTheyVanished) {
  Path path(9000, 9000);
  path.use_for(1min);
  path.takes(1500);
  path.use_for(250ms);
  EXPECT_EQ(path.take_lengths(), std::vector<std::size_t>{1280});
  path.use_for(5s);
  EXPECT_EQ(path.take_lengths(), (std::vector<std::size_t>{1400, 1450, 1492, 1500}));
}

TEST(PathMtuTest, TriesMoreAtThePaceOfASearchOnceWhatDidNotArriveArrives) {
  Path path(9000, 1400);
  path.use_for(1min);
  path.takes(9000);
  while (path.mtu().datagram_bytes() == payload(1400)) path.use_for(50ms);
  EXPECT_EQ(path.mtu().datagram_bytes(), payload(1450));
  path.take_lengths();
  path.use_for(4s);
  EXPECT_EQ(path.take_lengths(), (std::vector<std::size_t>{1492, 1500, 4352}));
}

TEST(PathMtuTest, GrowsToWhatTheKernelSaysAndNotBeyond) {
  Path path(1420, 1280);
  path.use_for(1s);
  path.takes(1420);
  path.use_for(1min);
  EXPECT_EQ(path.take_lengths(), (std::vector<std::size_t>{1280, 1400, 1420}));
}

TEST(PathMtuTest, IsInDoubtFromTheFirstLossOn) {
  PathMtu mtu(headers, shortest, payload(1500));
  PathMtu::Time now{1h};
  mtu.lost(mtu.datagram_bytes(), now);
  EXPECT_TRUE(mtu.is_uncertain());
  mtu.arrived(mtu.datagram_bytes(), now);
  EXPECT_FALSE(mtu.is_uncertain());
}

TEST(PathMtuTest, TakesAsManyLossesForEachLength) {
  PathMtu mtu(headers, shortest, payload(1500));
  PathMtu::Time now{1h};
  const auto lose = [&](int count) {
    for (; count > 0; --count, now += PathMtu::timeout) mtu.lost(mtu.datagram_bytes(), now);
  };
  lose(PathMtu::losses_max);
  EXPECT_EQ(mtu.datagram_bytes(), payload(1280));
  lose(PathMtu::losses_max - 1);
  EXPECT_EQ(mtu.datagram_bytes(), payload(1280));
  lose(1);
  EXPECT_EQ(mtu.datagram_bytes(), shortest);
}

TEST(PathMtuTest, TriesMoreAtTheMomentWhenItIsDue) {
  PathMtu mtu(headers, shortest, payload(1500));
  PathMtu::Time now{1h};
  for (int i = 0; i < PathMtu::losses_max; ++i, now += 50ms) mtu.lost(mtu.datagram_bytes(), now);
  mtu.arrived(mtu.datagram_bytes(), now);
  mtu.look_after(now + PathMtu::search_pause - 1ns);
  EXPECT_EQ(mtu.datagram_bytes(), payload(1280));
  mtu.look_after(now + PathMtu::search_pause);
  EXPECT_EQ(mtu.datagram_bytes(), payload(1400));
}

TEST(PathMtuTest, TriesNothingWhileNoReportSaysWhatArrives) {
  PathMtu mtu(headers, shortest, payload(9000));
  PathMtu::Time now{1h};
  for (int i = 0; i < PathMtu::losses_max; ++i, now += 50ms) mtu.lost(mtu.datagram_bytes(), now);
  ASSERT_EQ(mtu.datagram_bytes(), payload(1280));
  for (int i = 0; i < 10'000; ++i, now += 50ms) mtu.look_after(now);
  EXPECT_EQ(mtu.datagram_bytes(), payload(1280));
}

TEST(PathMtuTest, ShrinksForDatagramsThatAreShorterThanItsLength) {
  PathMtu mtu(headers, shortest, payload(1500));
  PathMtu::Time now{1h};
  for (int i = 0; i < PathMtu::losses_max; ++i, now += 50ms) {
    mtu.lost(1330, now);
    mtu.arrived(300, now);
  }
  EXPECT_EQ(mtu.datagram_bytes(), payload(1280));
  EXPECT_EQ(mtu.limited_to(), payload(1280));
}

TEST(PathMtuTest, TakesNoShorterDatagramForAProofOfItsLength) {
  PathMtu mtu(headers, shortest, payload(1500));
  PathMtu::Time now{1h};
  for (int i = 0; i < PathMtu::losses_max; ++i, now += 50ms) mtu.lost(payload(1500), now);
  mtu.arrived(payload(1280) - 1, now);
  mtu.look_after(now + 1h);
  EXPECT_EQ(mtu.datagram_bytes(), payload(1280));
}

TEST(PathMtuTest, CountsNoLossesOfDatagramsThatWereSentBeforeItShrank) {
  PathMtu mtu(headers, shortest, payload(1500));
  PathMtu::Time now{1h};
  for (int i = 0; i < 10 * PathMtu::losses_max; ++i, now += 50ms) mtu.lost(payload(1500), now);
  EXPECT_EQ(mtu.datagram_bytes(), payload(1280));
}

TEST(PathMtuTest, HasItsLimitUntilAllThatTheKernelSaysArrives) {
  Path path(1500, 1400);
  path.use_for(1min);
  EXPECT_EQ(path.mtu().limited_to(), payload(1400)) << "also while longer ones are tried";
  path.takes(1500);
  path.use_for(15min);
  EXPECT_EQ(path.mtu().datagram_bytes(), payload(1500));
  EXPECT_EQ(path.mtu().limited_to(), 0U);
}

TEST(PathMtuTest, HasNoLimitWhereAllThatTheKernelSaysArrives) {
  const PathMtu mtu(headers, shortest, payload(1500));
  EXPECT_EQ(mtu.limited_to(), 0U);
}

}  // namespace
}  // namespace sft::udp
