// kill -9 of writers and readers at random moments of their lives, some stopped before: nobody else notices,
// and their memory is accounted for. (Daemons and whole nodes: tests/system/kill_test.cpp.)
#include <signal.h>

#include <optional>

#include "shm_fixture.h"
#include "shm_transport/sftd/status.h"
#include "tests/support/test_seed.h"

namespace sft::test {
namespace {

using core::SendStatus;

constexpr int writers_killed = 165;
constexpr int readers_killed = 50;
constexpr int every_one_stopped_first = 33;  // of victims: 6 in all
constexpr core::EndpointId survivor = 1'000'000;

/// Told twice a second.
shm::Usage usage_now() {
  Process command({sftd_path(), "status", "--json"});
  return shm::parse_status(command.all_output()).value_or(shm::Status{}).usage;
}

std::uint32_t chunks_in_use(const shm::Usage& usage) {
  std::uint32_t sum = 0;
  for (const shm::PoolUse& pool : usage.pools) sum += pool.in_use;
  return sum;
}

class RandomKill : public ShmTest {
 protected:
  void SetUp() override {
    ShmTest::SetUp();
    if (IsSkipped()) return;
    node_ = std::make_unique<Node>();
    ASSERT_TRUE(node_->becomes_ready()) << (*node_)->description();
    writer_ = std::make_unique<Writer>(*node_, survivor);
    reader_ = std::make_unique<Reader>(*node_);
    ASSERT_TRUE(reader_->connects_to(survivor));
    daemon_ = daemon_pid();
  }
  void TearDown() override {
    reader_.reset();
    writer_.reset();
    node_.reset();
    ShmTest::TearDown();
  }

  std::uint32_t below(std::uint32_t end) { return static_cast<std::uint32_t>(random() % end); }

  /// Lives for a random time and is killed, now and then while it is stopped.
  void kill_some_time(Process& victim, int round) {
    poll(nullptr, 0, static_cast<int>(below(30)));
    if (round % every_one_stopped_first == every_one_stopped_first - 1) {
      victim.signal(SIGSTOP);
      ASSERT_TRUE(eventually([&] { return is_stopped(victim.pid()); }));
      expect_others_go_on();
      if (below(2) == 0) victim.signal(SIGCONT);
    }
    victim.kill();
  }

  void expect_others_go_on() {
    ASSERT_EQ(writer_->send_frame(), SendStatus::sent);
    const core::SampleHandle sample = reader_->next();
    ASSERT_TRUE(sample);
    ASSERT_EQ(sequence_of(sample), writer_->sequence());
  }

  /// The survivors' last sample is out, and at most one chunk for each kill. What a victim was delivering
  /// sftd heals; what it was just allocating or letting go of stays in use until sftd is idle and begins
  /// afresh.
  void expect_memory_accounted_for(std::uint32_t kills) {
    shm::Usage usage;
    const bool back = eventually(
        [&] {
          (*node_).poll();
          usage = usage_now();
          return usage.users.size() == 1 && chunks_in_use(usage) <= 1 + kills;
        },
        10s, 100ms);
    const std::string account = std::to_string(kills) + " kills, " + std::to_string(usage.deaths) +
                                " deaths, " + std::to_string(usage.locks_healed) + " locks and " +
                                std::to_string(usage.leaks_healed) + " chunks healed, " +
                                std::to_string(chunks_in_use(usage)) + " in use, " +
                                std::to_string(usage.users.size()) + " users";
    EXPECT_TRUE(back) << account;
    std::printf("%s\n", account.c_str());
    EXPECT_EQ(daemon_pid(), daemon_) << "the daemon did not survive";
  }

  Random random{test_seed()};
  const ::testing::ScopedTrace seed_{__FILE__, __LINE__, how_to_repeat()};
  std::unique_ptr<Node> node_;
  std::unique_ptr<Writer> writer_;
  std::unique_ptr<Reader> reader_;
  pid_t daemon_ = 0;
};

// Half of them are read by somebody; some have hardly begun.
TEST_F(RandomKill, OfWritersWedgesNobodyAndCostsAtMostOneChunkEach) {
  for (int round = 0; round < writers_killed; ++round) {
    SCOPED_TRACE(round);
    const auto id = std::to_string(1 + round);
    const char* const pace = below(3) == 0 ? "publish-paced" : "publish";
    Process victim = start_peer({pace, id, std::to_string(below(2) == 0 ? 100 : 60'000)});
    std::optional<Reader> reader;
    if (below(4) != 0) {
      ASSERT_EQ(victim.line(), "publishing");
    }
    if (below(2) == 0) {
      reader.emplace(*node_);
      ASSERT_TRUE(reader->connects_to(std::stoull(id)));
      ASSERT_TRUE(reader->next());
    }
    kill_some_time(victim, round);
    expect_others_go_on();
    ASSERT_FALSE(HasFatalFailure());
  }
  expect_memory_accounted_for(writers_killed);
}

TEST_F(RandomKill, OfReadersCostsNobodyAnythingButAtMostOneChunkEach) {
  for (int round = 0; round < readers_killed; ++round) {
    SCOPED_TRACE(round);
    Process victim = start_peer({"subscribe", std::to_string(survivor)});
    if (below(4) != 0) {
      ASSERT_EQ(victim.line(), "subscribed");
      const std::uint32_t samples = below(2000);
      for (std::uint32_t i = 0; i < samples; ++i) {
        ASSERT_EQ(writer_->send_frame(), SendStatus::sent);
        const core::SampleHandle sample = reader_->take();
        ASSERT_TRUE(sample);
        ASSERT_EQ(sequence_of(sample), writer_->sequence());
      }
    }
    kill_some_time(victim, round);
    expect_others_go_on();
    ASSERT_FALSE(HasFatalFailure());
  }
  expect_memory_accounted_for(readers_killed);
}

}  // namespace
}  // namespace sft::test
