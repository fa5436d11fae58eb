// Rows "Join", "Leave" and "Leases" of negotiation.md with many nodes at once, each on its own host.
#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string_view>
#include <vector>

#include "core/platform/text_of.h"
#include "tests/pairs/fixture.h"

namespace sft::test {
namespace {

/// Returns the number of times that threads of the process have gone to sleep so far.
std::uint64_t wakes_of(pid_t process) {
  std::uint64_t wakes = 0;
  const std::string threads = "/proc/" + std::to_string(process) + "/task";
  for (const auto& thread : std::filesystem::directory_iterator(threads)) {
    static constexpr std::string_view label = "\nvoluntary_ctxt_switches:";
    const std::string status = core::text_of(thread.path() / "status");
    if (const auto at = status.find(label); at != std::string::npos)
      wakes += std::strtoull(status.c_str() + at + label.size(), nullptr, 10);
  }
  return wakes;
}

class ManyNodes : public NegotiationTest {
 protected:
  static constexpr std::size_t size = 12;

  void SetUp() override {
    NegotiationTest::SetUp();
    if (IsSkipped()) return;
    publisher_ = std::make_unique<Peer>(here(), "publisher");
    publisher_->advertise();
    for (std::size_t i = 0; i < size; ++i) hosts_.push_back(std::make_unique<Host>(network()));
    readers_.resize(size);
  }

  Peer& publisher() { return *publisher_; }
  Peer& reader(std::size_t i) { return *readers_[i]; }

  /// Starts the readers from number `from` to before `to`. All processes are started before the first one is
  /// awaited.
  void start(std::size_t from, std::size_t to) {
    static constexpr std::array masks{"data", "height, width", "*"};
    for (std::size_t i = from; i < to; ++i)
      readers_[i] = std::make_unique<Peer>(*hosts_[i], "reader_" + std::to_string(++started_));
    for (std::size_t i = from; i < to; ++i) reader(i).subscribe(masks[i % masks.size()]);
  }
  testing::AssertionResult are_served() {
    for (const auto& reader : readers_) {
      if (!comes_true([&] { return is_served(publisher(), *reader); }))
        return testing::AssertionFailure() << reader->name() << ": " << reader_of(publisher(), *reader);
    }
    return testing::AssertionSuccess();
  }
  bool all_are_served() {
    return std::ranges::all_of(readers_, [&](const auto& reader) { return is_served(publisher(), *reader); });
  }
  /// Publishes as many samples as may wait for one destination. Returns when the first `count` readers have
  /// taken these samples. So none of the samples is dropped for a newer one, even on a slow machine.
  testing::AssertionResult get_a_few(std::size_t count) {
    static constexpr std::uint64_t lane_depth = 4;  // the default of send_queue_depth
    publisher().publish(lane_depth);
    published_ += lane_depth;
    for (std::size_t i = 0; i < count; ++i) {
      json seen;
      const auto has_all = [&] {
        seen = reader(i).look_at(publisher().name());
        return seen.contains("taken") && seen["taken"]["last"] == published_;
      };
      if (!comes_true(has_all))
        return testing::AssertionFailure() << reader(i).name() << " waits for " << published_ << ": " << seen;
    }
    return testing::AssertionSuccess();
  }
  /// Publishes until the queues to all readers after the first `survivors` are full. Those readers were
  /// killed. The survivors get all samples meanwhile.
  testing::AssertionResult get_all_while_others_hang(std::size_t survivors) {
    testing::AssertionResult got = testing::AssertionSuccess();
    const auto is_stuck = [&](const auto& killed) {
      const json seen = reader_of(publisher(), *killed);
      return !seen.is_null() && seen["dropped"] > 0;
    };
    const bool stuck = comes_true([&] {
      got = get_a_few(survivors);
      return !got ||
             std::all_of(readers_.begin() + static_cast<std::ptrdiff_t>(survivors), readers_.end(), is_stuck);
    });
    if (!got || stuck) return got;
    return testing::AssertionFailure() << "the publisher was never seen to hold samples back for the killed";
  }
  void expect_all_accounted() {
    for (const auto& reader : readers_) {
      EXPECT_TRUE(agree(publisher(), *reader));
      EXPECT_TRUE(accounts_for_all(publisher(), *reader));
    }
  }
  std::size_t served() {
    const json readers = publisher().status()["publisher"]["readers"];
    return static_cast<std::size_t>(
        std::ranges::count_if(readers, [](const json& reader) { return reader["served"].get<bool>(); }));
  }
  /// Waits for a second in which the network carries at most `frames_most` frames, and the threads of the
  /// publisher's process wake up at most `wakes_most` times.
  testing::AssertionResult has_a_quiet_second(std::uint64_t frames_most, std::uint64_t wakes_most) {
    auto begin = std::chrono::steady_clock::now();
    std::uint64_t frames = network().frames(), wakes = wakes_of(publisher().pid());
    std::uint64_t new_frames = 0, new_wakes = 0;
    const auto is_quiet = [&] {
      const auto now = std::chrono::steady_clock::now();
      if (now < begin + 1s) return false;
      begin = now;
      new_frames = network().frames() - frames;
      new_wakes = wakes_of(publisher().pid()) - wakes;
      frames += new_frames;
      wakes += new_wakes;
      return new_frames <= frames_most && new_wakes <= wakes_most;
    };
    const bool quiet = comes_true(is_quiet);
    return (quiet ? testing::AssertionSuccess() : testing::AssertionFailure())
           << new_frames << " frames and " << new_wakes << " wakes in the last second";
  }

 private:
  std::unique_ptr<Peer> publisher_;
  std::vector<std::unique_ptr<Host>> hosts_;
  std::vector<std::unique_ptr<Peer>> readers_;
  std::size_t started_ = 0;
  std::uint64_t published_ = 0;
};

TEST_F(ManyNodes, ThatJoinsAtOnceOverABadNetworkIsServedAndMissesNothingUnnoticed) {
  SCOPED_TRACE(how_to_repeat());
  network().set_faults({.lost = 0.1, .repeated = 0.05, .delayed = 0.1});
  publisher().start_publishing(5ms);
  start(0, size);
  EXPECT_TRUE(are_served());
  network().set_faults({});
  publisher().stop_publishing();
  expect_all_accounted();
}

/// The survivors get best-effort samples, so a lost sample is not repaired. The test publishes only as fast
/// as the survivors take, because the publisher would otherwise drop samples on a slow machine.
TEST_F(ManyNodes, OfWhichAThirdIsKilledAgainAndAgainWhileOthersComeCostsTheRestNothing) {
  start(0, size);
  ASSERT_TRUE(are_served());
  constexpr std::size_t survivors = size - size / 3;
  ASSERT_TRUE(get_a_few(survivors));
  for (int round = 0; round < 3; ++round) {
    for (std::size_t i = survivors; i < size; ++i) reader(i).kill_now();
    ASSERT_TRUE(get_all_while_others_hang(survivors));
    start(survivors, size);
    testing::AssertionResult got = testing::AssertionSuccess();
    EXPECT_TRUE(comes_true([&] { return !(got = get_a_few(survivors)) || all_are_served(); }));
    ASSERT_TRUE(got);
  }
  expect_all_accounted();
  for (std::size_t i = 0; i < survivors; ++i)
    EXPECT_EQ(writer_of(publisher(), reader(i))["lost"], 0) << reader_of(publisher(), reader(i));
  EXPECT_TRUE(comes_true([&] { return served() == size; })) << "the killed ones are still served";
}

/// Each node sends one heartbeat per second. The heartbeats of other nodes wake no thread of a node.
TEST_F(ManyNodes, ThatIsAsleepSaysLittleAndWakesNobody) {
  start(0, size);
  ASSERT_TRUE(are_served());
  constexpr std::size_t nodes = size + 1;
  EXPECT_TRUE(has_a_quiet_second(nodes * 3 / 2, nodes / 2));
}

}  // namespace
}  // namespace sft::test
