// kill -9 of writers and readers at random moments of their lives, some stopped before: nobody else notices,
// and their memory comes back. (Daemons and whole nodes: tests/system/kill_test.cpp.)
#include <signal.h>

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

  /// The dead have nothing any more: only the survivors' last sample is out.
  void expect_memory_back() {
    shm::Usage usage;
    const bool back = eventually(
        [&] {
          (*node_).poll();
          usage = usage_now();
          return usage.users.size() == 1 && chunks_in_use(usage) <= 1;
        },
        10s, 100ms);
    EXPECT_TRUE(back) << chunks_in_use(usage) << " chunks in use, " << usage.deaths << " deaths, "
                      << usage.users.size() << " users";
    std::printf("%llu deaths, %llu locks and %llu chunks healed\n",
                static_cast<unsigned long long>(usage.deaths),
                static_cast<unsigned long long>(usage.locks_healed),
                static_cast<unsigned long long>(usage.leaks_healed));
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
TEST_F(RandomKill, OfWritersWedgesNobodyAndTheirMemoryComesBack) {
  for (int round = 0; round < writers_killed; ++round) {
    SCOPED_TRACE(round);
    const auto id = std::to_string(1 + below(3));  // of the same name as one that was killed before
    const char* const pace = below(3) == 0 ? "publish-paced" : "publish";
    Process victim = start_peer({pace, id, std::to_string(below(2) == 0 ? 100 : 60'000)});
    if (below(4) != 0) {
      ASSERT_EQ(victim.line(), "publishing");
      if (below(2) == 0) {
        Reader reader(*node_);
        ASSERT_TRUE(reader.connects_to(std::stoull(id)));
        ASSERT_TRUE(reader.next());
        kill_some_time(victim, round);
      }
    }
    kill_some_time(victim, round);
    expect_others_go_on();
    ASSERT_FALSE(HasFatalFailure());
  }
  expect_memory_back();
}

TEST_F(RandomKill, OfReadersCostsNobodyAnythingAndTheirMemoryComesBack) {
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
  expect_memory_back();
}

}  // namespace
}  // namespace sft::test
