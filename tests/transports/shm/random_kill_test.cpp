// Writers and readers are killed with SIGKILL at random moments, and some of them are stopped before. No
// other program is disturbed, and all memory of the killed programs becomes free again.
// (tests/system/kill_test.cpp does the same with whole nodes.)
#include <signal.h>

#include <atomic>
#include <optional>
#include <ostream>
#include <thread>

#include "core/platform/clock.h"
#include "shm_transport/sftd/status.h"
#include "tests/support/test_seed.h"
#include "tests/transports/shm/shm_fixture.h"

namespace sft::test {
namespace {

using core::SendStatus;

constexpr core::EndpointId daemons_killed = 8;
constexpr int victims_for_each_stop = 15;         // one in so many victims is stopped before it is killed
constexpr core::EndpointId survivor = 2'000'000;  // an id that no ChunkCounter uses

/// Returns the memory usage that sftd has written last. sftd writes it twice a second.
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
  RandomKill()
      // Leaves room for the memory of dead daemons, which stays until all programs that map it have ended.
      : ShmTest(1024) {}
  void SetUp() override {
    ShmTest::SetUp();
    if (IsSkipped()) return;
    node_ = std::make_unique<Node>();
    ASSERT_TRUE(node_->becomes_ready()) << (*node_)->description();
    writer_ = std::make_unique<Writer>(*node_, survivor);
    reader_ = std::make_unique<Reader>(*node_);
    ASSERT_TRUE(reader_->connects_to(survivor));
    daemon_ = daemon_pid();
    ASSERT_EQ(writer_->send_frame(), SendStatus::sent);
    ASSERT_TRUE(reader_->next());
    chunks_before_ = chunks_.emplace(*node_, 100).free();
  }
  void TearDown() override {
    reader_.reset();
    writer_.reset();
    chunks_.reset();
    node_.reset();
    ShmTest::TearDown();
  }

  std::uint32_t below(std::uint32_t end) { return static_cast<std::uint32_t>(random() % end); }

  /// Kills the victim after a random time. Some victims are stopped first.
  void kill_some_time(Process& victim, int round) {
    poll(nullptr, 0, static_cast<int>(below(30)));
    if (round % victims_for_each_stop == victims_for_each_stop - 1) {
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

  /// Expects that only the chunk of the survivor's last sample is in use, and that all other chunks are free.
  void expect_all_memory_back(int kills) {
    shm::Usage usage;
    const std::int64_t since_ns = core::realtime_ns();
    const bool back = eventually(
        [&] {
          (*node_).poll();
          usage = usage_now();
          return usage.stamp_ns > since_ns && usage.users.size() == 1 && usage.unaudited == 0 &&
                 chunks_in_use(usage) == 1;
        },
        30s, 100ms);
    const std::string summary = std::to_string(kills) + " kills, " + std::to_string(usage.deaths) +
                                " deaths, " + std::to_string(usage.locks_healed) + " locks and " +
                                std::to_string(usage.leaks_healed) + " chunks healed, " +
                                std::to_string(chunks_in_use(usage)) + " in use, " +
                                std::to_string(usage.users.size()) + " users";
    EXPECT_TRUE(back) << summary;
    std::printf("%s; %s\n", summary.c_str(), how_to_repeat().c_str());
    // A death costs at most two chunks: the chunk that was being delivered, and the chunk that this one
    // displaced from a queue.
    EXPECT_LE(usage.leaks_healed, 2 * usage.deaths);
    EXPECT_TRUE(chunks_->comes_to(chunks_before_));
    EXPECT_EQ(daemon_pid(), daemon_) << "the daemon did not survive";
  }

  Random random{test_seed()};
  const ::testing::ScopedTrace seed_{__FILE__, __LINE__, how_to_repeat()};
  std::unique_ptr<Node> node_;
  std::optional<ChunkCounter> chunks_;
  std::size_t chunks_before_ = 0;
  std::unique_ptr<Writer> writer_;
  std::unique_ptr<Reader> reader_;
  pid_t daemon_ = 0;
};

/// The task of the victims in a test, and their number.
struct Life {
  const char* name;
  const char* role;  ///< the argument of shm_peer
  int kills;
  bool settled;  ///< true: the victim is killed after it has reported success; false: shortly after its start
  bool is_read = false;  ///< whether a reader takes the victim's samples
};
void PrintTo(const Life& life, std::ostream* out) { *out << life.kills << " kills"; }
std::string name_of(const ::testing::TestParamInfo<Life>& info) { return info.param.name; }

class RandomKillOfWriters : public RandomKill, public ::testing::WithParamInterface<Life> {};

TEST_P(RandomKillOfWriters, BlocksNobodyAndAllMemoryComesBack) {
  const Life& life = GetParam();
  for (int round = 0; round < life.kills; ++round) {
    SCOPED_TRACE(round);
    const auto id = static_cast<core::EndpointId>(1 + round);
    Process victim =
        start_peer({life.role, std::to_string(id), std::to_string(below(2) == 0 ? 100 : 60'000)});
    std::optional<Reader> reader;
    if (life.settled) {
      const std::string line = victim.line();
      ASSERT_EQ(line, "publishing") << victim.line() << victim.line();
    }
    if (life.is_read) {
      reader.emplace(*node_);
      ASSERT_TRUE(reader->connects_to(id));
      ASSERT_TRUE(reader->next());
    }
    kill_some_time(victim, round);
    expect_others_go_on();
    ASSERT_FALSE(HasFatalFailure());
  }
  expect_all_memory_back(life.kills);
}

INSTANTIATE_TEST_SUITE_P(Lives, RandomKillOfWriters,
                         ::testing::Values(Life{"OnesThatNobodyReads", "publish", 45, true},
                                           Life{"ReadOnes", "publish", 60, true, true},
                                           Life{"PacedOnes", "publish-paced", 45, true, true},
                                           Life{"OnesThatHaveHardlyBegun", "publish", 15, false}),
                         name_of);

class RandomKillOfReaders : public RandomKill, public ::testing::WithParamInterface<Life> {};

// A chunk that a killed reader held belongs to its writer. The chunk becomes free when the writer has ended,
// too.
TEST_P(RandomKillOfReaders, CostsOtherProgramsNothingAndAllMemoryComesBack) {
  const Life& life = GetParam();
  for (int round = 0; round < life.kills; ++round) {
    SCOPED_TRACE(round);
    Process victim = start_peer({life.role, std::to_string(survivor)});
    if (life.settled) {
      ASSERT_EQ(victim.line(), "subscribed");
      const std::uint32_t samples = below(2000);
      for (std::uint32_t i = 0; i < samples; ++i) expect_others_go_on();
    }
    kill_some_time(victim, round);
    expect_others_go_on();
    ASSERT_FALSE(HasFatalFailure());
  }
  reader_.reset();
  writer_ = std::make_unique<Writer>(*node_, survivor + 1);
  ASSERT_EQ(writer_->send_frame(), SendStatus::sent);
  expect_all_memory_back(life.kills);
}

INSTANTIATE_TEST_SUITE_P(Lives, RandomKillOfReaders,
                         ::testing::Values(Life{"ThatTake", "subscribe", 25, true},
                                           Life{"ThatTakeNowAndThen", "subscribe-paced", 10, true},
                                           Life{"ThatHaveHardlyBegun", "subscribe", 15, false}),
                         name_of);

// Neither peer notices the death of the daemon. Both continue in its memory.
TEST_F(RandomKill, OfDaemonsNeitherBlocksNorHarmsProgramsInATightLoop) {
  for (core::EndpointId round = 0; round < daemons_killed; ++round) {
    SCOPED_TRACE(round);
    Writer writer(*node_, 1);
    Reader reader(*node_);
    ASSERT_TRUE(reader.connects_to(1));
    Process publisher = start_peer({"publish", "2"});
    ASSERT_EQ(publisher.line(), "publishing");
    Process subscriber = start_peer({"subscribe", "2"});
    ASSERT_EQ(subscriber.line(), "subscribed");
    std::atomic<bool> done{false}, taking{false};
    std::thread writing([&] {
      while (!done) writer.send_frame();
    });
    core::SampleHandle held;
    std::uint64_t last = 0;
    std::thread reading([&] {
      while (!done) {
        core::SampleHandle sample = reader.take();
        if (!sample) continue;
        EXPECT_GT(sequence_of(sample), last);
        last = sequence_of(sample);
        held = std::move(sample);
        taking = true;
      }
    });
    EXPECT_TRUE(eventually([&] { return taking.load(); }));
    poll(nullptr, 0, static_cast<int>(below(30)));
    ::kill(daemon_pid(), SIGKILL);
    EXPECT_TRUE(eventually([&] { return (*node_).poll() != core::Availability::ready; }));
    EXPECT_TRUE(node_->becomes_ready()) << (*node_)->description();
    done = true;
    writing.join();
    reading.join();
    ASSERT_TRUE(held);
    EXPECT_EQ(sequence_of(held), last);
    EXPECT_EQ(field_of(*held, 0), static_cast<std::uint32_t>(last));
    EXPECT_TRUE(publisher.runs() && subscriber.runs());
  }
}

}  // namespace
}  // namespace sft::test
