// The daemon dies, is stopped or is restarted, and nodes and ports are closed, while samples are held.
#include <signal.h>

#include <fstream>

#include "tests/transports/shm/shm_fixture.h"

namespace sft::test {
namespace {

using core::Availability;
using core::SampleHandle;
using core::SendStatus;

class Loss : public ShmTest {
 protected:
  void kill_daemon() {
    const pid_t daemon = daemon_pid();
    ASSERT_GT(daemon, 0);
    ::kill(daemon, SIGKILL);
    ASSERT_TRUE(eventually([daemon] { return !is_alive(daemon); }));
  }
};

TEST_F(Loss, OfTheDaemonIsNoticedAtTheNextPoll) {
  Node node;
  ASSERT_TRUE(node.becomes_ready()) << node->description();
  kill_daemon();
  EXPECT_NE(node.poll(), Availability::ready);
  EXPECT_FALSE(node->host_token().known());
}

TEST_F(Loss, IsFollowedByANewDaemonWithANewToken) {
  Node node;
  for (int round = 0; round < 5; ++round) {
    ASSERT_TRUE(node.becomes_ready()) << node->description();
    const core::HostToken token = node->host_token();
    Writer writer(node, 1);
    Reader reader(node);
    ASSERT_TRUE(reader.connects_to(1));
    EXPECT_EQ(writer.send_frame(), SendStatus::sent);
    EXPECT_TRUE(reader.next());
    kill_daemon();
    EXPECT_NE(node.poll(), Availability::ready);
    EXPECT_EQ(writer.send_frame(), SendStatus::dropped) << "a dead port lends nothing";
    EXPECT_FALSE(reader.take());
    ASSERT_TRUE(node.becomes_ready()) << node->description();
    EXPECT_NE(node->host_token(), token);
  }
}

TEST_F(Loss, OfADaemonThatWasTerminatedIsFollowedByANewDaemonToo) {
  Node node;
  ASSERT_TRUE(node.becomes_ready()) << node->description();
  Writer writer(node, 1);
  const core::HostToken token = node->host_token();
  ::kill(daemon_pid(), SIGTERM);
  while (node.poll() == Availability::ready) writer.send_frame();
  ASSERT_TRUE(node.becomes_ready()) << node->description();
  EXPECT_NE(node->host_token(), token);
}

TEST_F(Loss, IsReportedToEveryNodeOfTheProcess) {
  Node first;
  Node second(no_daemon());
  ASSERT_TRUE(first.becomes_ready()) << first->description();
  ASSERT_TRUE(second.becomes_ready()) << second->description();
  kill_daemon();
  ASSERT_NE(first.poll(), Availability::ready);
  ASSERT_TRUE(first.becomes_ready()) << first->description();
  EXPECT_NE(second.poll(), Availability::ready)
      << "the second node must not go on with ports of the dead daemon";
  EXPECT_TRUE(second.becomes_ready()) << second->description();
}

TEST_F(Loss, LeavesLentAndReceivedSamplesReadable) {
  Node node;
  ASSERT_TRUE(node.becomes_ready()) << node->description();
  auto writer = std::make_unique<Writer>(node, 1);
  auto reader = std::make_unique<Reader>(node);
  ASSERT_TRUE(reader->connects_to(1));
  writer->send_frame();
  SampleHandle received = reader->next();
  SampleHandle lent = writer->loan(5000);
  kill_daemon();
  ASSERT_NE(node.poll(), Availability::ready);
  ASSERT_TRUE(node.becomes_ready()) << node->description();
  std::memset(data_of(*lent), 1, 5000);
  EXPECT_EQ(writer->port().send(lent), SendStatus::lost_port);
  EXPECT_EQ(sequence_of(received), 1U);
  writer.reset();
  reader.reset();
  Writer next(node, 2);
  EXPECT_EQ(next.send_frame(), SendStatus::sent);
  received.reset();
  lent.reset();
  EXPECT_EQ(next.send_frame(), SendStatus::sent) << "samples of the dead daemon must not disturb the new one";
}

TEST_F(Loss, OfTheDaemonKeepsTheSamplesThatHaveArrived) {
  constexpr std::uint64_t sent = 5;
  Node node;
  ASSERT_TRUE(node.becomes_ready()) << node->description();
  Writer writer(node, 1);
  Reader reader(node);
  ASSERT_TRUE(reader.connects_to(1));
  for (std::uint64_t i = 0; i < sent; ++i) EXPECT_EQ(writer.send_frame(), SendStatus::sent);
  const auto before = reader.port().arrivals(1);
  kill_daemon();
  ASSERT_NE(node.poll(), Availability::ready);
  EXPECT_EQ(before, sent);
  ASSERT_TRUE(node.becomes_ready()) << node->description();
  Writer next(node, 2);
  std::vector<SampleHandle> taken;
  for (std::uint64_t i = 1; i <= sent; ++i) {
    EXPECT_EQ(next.send_frame(), SendStatus::sent);
    taken.push_back(reader.take());
    ASSERT_TRUE(taken.back()) << i;
    EXPECT_EQ(sequence_of(taken.back()), i);
  }
  EXPECT_FALSE(reader.take());
  EXPECT_EQ(reader.port().counters().discarded, 0U);
}

TEST_F(Loss, OfTheDaemonLeavesTheOldestSamplesToBeTakenOnceOthersAreGivenBack) {
  Node node;
  ASSERT_TRUE(node.becomes_ready()) << node->description();
  Writer writer(node, 1);
  const auto port =
      node->open_reader({.id = reader_id, .type = &frame_type(), .depth = 8, .doorbell = {}, .max_held = 2});
  ASSERT_TRUE(port) << port.error().message;
  ASSERT_TRUE((*port)->connect({.writer = 1, .max_sample_bytes = 1 << 20}));
  ASSERT_TRUE(eventually([&] { return (*port)->connected(1); }));
  for (int i = 0; i < 4; ++i) EXPECT_EQ(writer.send_frame(), SendStatus::sent);
  kill_daemon();
  ASSERT_NE(node.poll(), Availability::ready);
  SampleHandle first = (*port)->take();
  SampleHandle second = (*port)->take();
  EXPECT_FALSE((*port)->take()) << "no more than two may be held";
  EXPECT_EQ((*port)->held_too_many(), 1U);
  EXPECT_EQ(sequence_of(second), 2U);
  first.reset();
  EXPECT_EQ(sequence_of((*port)->take()), 3U);
  EXPECT_EQ(sequence_of((*port)->take()), 4U);
}

/// Returns true if samples of a daemon are mapped in this process.
bool maps_samples() {
  std::ifstream maps("/proc/self/maps");
  for (std::string line; std::getline(maps, line);) {
    if (line.find("/dev/shm/") != std::string::npos && line.find("sft_bell") == std::string::npos)
      return true;
  }
  return false;
}

TEST_F(Loss, OfTheDaemonFreesItsMemoryUnderAWriterThatSendsNothing) {
  Node node;
  ASSERT_TRUE(node.becomes_ready()) << node->description();
  Writer writer(node, 1);
  SampleHandle lent = writer.loan(100);
  writer.send_frame();
  kill_daemon();
  ASSERT_NE(node.poll(), Availability::ready);
  EXPECT_TRUE(maps_samples()) << "a sample is still lent";
  lent.reset();
  EXPECT_FALSE(maps_samples());
  EXPECT_FALSE(writer.loan(100));
}

TEST_F(Loss, OfTheDaemonLetsReadersAndWritersGoOnUntilTheyNotice) {
  Node node;
  ASSERT_TRUE(node.becomes_ready()) << node->description();
  Writer writer(node, 1);
  Reader reader(node);
  ASSERT_TRUE(reader.connects_to(1));
  kill_daemon();
  for (int i = 0; i < 1000; ++i) {
    ASSERT_EQ(writer.send_frame(), SendStatus::sent);
    ASSERT_TRUE(reader.take());
  }
}

TEST_F(Loss, OfNodeWriterAndReaderLeavesASampleReadable) {
  SampleHandle sample;
  SampleHandle loan;
  {
    Node node;
    ASSERT_TRUE(node.becomes_ready()) << node->description();
    Writer writer(node, 1);
    Reader reader(node);
    ASSERT_TRUE(reader.connects_to(1));
    writer.send_frame();
    sample = reader.next();
    loan = writer.loan(100);
  }
  ASSERT_TRUE(sample);
  EXPECT_EQ(sequence_of(sample), 1U);
  EXPECT_EQ(names_in("/tmp", "sft_node").size(), 1U)
      << "the process stays registered while it holds a sample";
  loan.reset();
  sample.reset();
  EXPECT_EQ(names_in("/tmp", "sft_node").size(), 0U);
  kill_daemon();
}

TEST_F(Loss, OfWriterAndReaderGivesTheirMemoryBack) {
  Node node;
  ASSERT_TRUE(node.becomes_ready()) << node->description();
  ChunkCounter chunks(node, 4'000'000);
  const std::size_t before = chunks.free();
  {
    Writer writer(node, 1);
    Reader reader(node);
    ASSERT_TRUE(reader.connects_to(1));
    writer.send_frame(4'000'000);
    const SampleHandle held = reader.next();
    EXPECT_LT(chunks.free(), before);
  }
  EXPECT_TRUE(chunks.comes_to(before));
}

class StoppedDaemon : public Loss {
 protected:
  void stop_daemon() {
    const pid_t daemon = daemon_pid();
    ::kill(daemon, SIGSTOP);
    EXPECT_TRUE(eventually([daemon] { return is_stopped(daemon); }));
  }
  void TearDown() override {
    if (daemon_pid() > 0) ::kill(daemon_pid(), SIGCONT);
    Loss::TearDown();
  }
  static Clock::duration time_of(const std::function<void()>& action) {
    const auto begin = Clock::now();
    action();
    return Clock::now() - begin;
  }
};

TEST_F(StoppedDaemon, BlocksNoCallBeyondItsDeadline) {
  Node node;
  ASSERT_TRUE(node.becomes_ready()) << node->description();
  Writer writer(node, 1);
  auto reader = std::make_unique<Reader>(node);
  ASSERT_TRUE(reader->connects_to(1));
  stop_daemon();
  EXPECT_LT(time_of([&] {
              const auto refused = node->open_writer({.id = 2, .type = &frame_type()});
              ASSERT_FALSE(refused);
              EXPECT_NE(refused.error().message.find("stopped"), std::string::npos)
                  << refused.error().message;
            }),
            hang_timeout);
  EXPECT_LT(time_of([&] { EXPECT_FALSE(reader->port().connect({.writer = 9})); }), hang_timeout);
  EXPECT_LT(time_of([&] {
              EXPECT_EQ(writer.send_frame(), SendStatus::sent);
              EXPECT_TRUE(reader->take());
            }),
            hang_timeout)
      << "samples must flow without the daemon";
  EXPECT_LT(time_of([&] { reader.reset(); }), hang_timeout);
  EXPECT_LT(time_of([&] { node.poll(); }), hang_timeout);
}

TEST_F(StoppedDaemon, DoesNotBlockTheEndOfANode) {
  auto node = std::make_unique<Node>();
  ASSERT_TRUE(node->becomes_ready()) << (*node)->description();
  auto writer = std::make_unique<Writer>(*node, 1);
  stop_daemon();
  EXPECT_LT(time_of([&] {
              writer.reset();
              node.reset();
            }),
            hang_timeout);
}

TEST_F(StoppedDaemon, IsNamedByANodeThatStartsMeanwhile) {
  Process first = start_peer({"attend"});
  ASSERT_EQ(first.line(), "ready");
  stop_daemon();
  Node node;
  ASSERT_TRUE(node.becomes(Availability::unavailable));
  EXPECT_NE(node->description().find("stopped"), std::string::npos) << node->description();
  ::kill(daemon_pid(), SIGCONT);
  EXPECT_TRUE(node.becomes_ready()) << node->description();
}

TEST_F(StoppedDaemon, MakesNoNodeWaitForTheNextDaemon) {
  Process first = start_peer({"attend"});
  ASSERT_EQ(first.line(), "ready");
  stop_daemon();
  Node node(no_daemon());
  auto now = Clock::now();
  for (int refusals = 0; refusals < 5;) {
    refusals += node->poll(now += 20s) == Availability::unavailable ? 1 : 0;
  }
  first.kill();
  end_daemon();
  Process next({sftd_path(), "--foreground", "--log-level=error", "--pool-mib=16"});
  ASSERT_EQ(next.line(), "sftd: ready");
  EXPECT_TRUE(eventually([&] { return node->poll(now) == Availability::ready; })) << node->description();
}

TEST_F(StoppedDaemon, AnswersLaterAndTheLateAnswersHarmNobody) {
  Node node;
  ASSERT_TRUE(node.becomes_ready()) << node->description();
  stop_daemon();
  for (core::EndpointId id = 10; id < 13; ++id) {
    EXPECT_FALSE(node->open_writer({.id = id, .type = &frame_type()}));
  }
  ::kill(daemon_pid(), SIGCONT);
  Writer writer(node, 10);
  Reader reader(node);
  ASSERT_TRUE(reader.connects_to(10));
  EXPECT_EQ(writer.send_frame(), SendStatus::sent);
  EXPECT_TRUE(reader.next());
}

}  // namespace
}  // namespace sft::test
