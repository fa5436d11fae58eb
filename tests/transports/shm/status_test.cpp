// The commands `sftd status` and `sftd stop`, with and without a daemon that answers.
#include <signal.h>

#include <fstream>

#include "shm_transport/sftd/exit_code.h"
#include "shm_transport/sftd/status.h"
#include "tests/transports/shm/shm_fixture.h"

namespace sft::test {
namespace {

using shm::ExitCode;
using shm::Status;

struct Answer {
  std::string text;
  ExitCode code;
};

Answer call(std::vector<std::string> words) {
  words.insert(words.begin(), sftd_path());
  Process command(words);
  std::string text = command.all_output();
  return {std::move(text), static_cast<ExitCode>(command.exit_code())};
}

Status status_now() { return shm::parse_status(call({"status", "--json"}).text).value_or(Status{}); }

/// Returns true if the status fulfils the condition before a deadline. sftd writes its status twice a second.
template <class Condition>
bool status_becomes(Condition condition) {
  return eventually([&] { return condition(status_now()); });
}

class SftdCommands : public ShmTest {
 protected:
  static Process start_sftd() {
    Process daemon({sftd_path(), "--foreground", "--log-level=error", "--pool-mib=16", "--idle-exit=600"});
    EXPECT_EQ(daemon.line(), "sftd: ready");
    return daemon;
  }
};

TEST_F(SftdCommands, SayThatNoDaemonIsRunning) {
  for (const char* command : {"status", "stop"}) {
    const Answer answer = call({command});
    EXPECT_EQ(answer.text, "sftd: no daemon is running\n");
    EXPECT_EQ(answer.code, ExitCode::not_running);
  }
}

TEST_F(SftdCommands, ShowThePidVersionsAndSettingsOfTheDaemon) {
  Process daemon = start_sftd();
  const Status status = status_now();
  EXPECT_EQ(status.pid, daemon.pid());
  EXPECT_EQ(status.versions.iceoryx.rfind("2.0.", 0), 0U) << status.versions.iceoryx;
  EXPECT_FALSE(status.versions.sftd.empty());
  EXPECT_EQ(status.idle_exit_s, 600);
  EXPECT_GT(status.since_ns, 0);
  const Answer table = call({"status"});
  EXPECT_EQ(table.code, ExitCode::done);
  EXPECT_TRUE(contains(table.text, "idle exit after 600 s")) << table.text;
}

/// Calls the command with a full disk in place of its standard output. The text is what it writes to its
/// standard error.
Answer call_on_full_disk(const std::string& words) {
  Process command({"/bin/sh", "-c", "exec " + sftd_path() + " " + words + " 2>&1 >/dev/full"});
  std::string text = command.all_output();
  return {std::move(text), static_cast<ExitCode>(command.exit_code())};
}

TEST_F(SftdCommands, SayThatTheDiskIsFull) {
  Process daemon = start_sftd();
  ASSERT_TRUE(status_becomes([&](const Status& status) { return status.pid == daemon.pid(); }));
  const Answer status = call_on_full_disk("status");
  EXPECT_EQ(status.text, "sftd: the status cannot be written: No space left on device\n");
  EXPECT_EQ(status.code, ExitCode::failed);
  const Answer stop = call_on_full_disk("stop");
  EXPECT_EQ(stop.text,
            "sftd: the daemon (pid " + std::to_string(daemon.pid()) +
                ") has ended; which programs used it cannot be written: No space left on device\n");
  EXPECT_EQ(stop.code, ExitCode::failed);
  EXPECT_EQ(daemon.exit_code(), 0);
}

TEST_F(SftdCommands, SayThatTheDiskIsFullForAStatusOfAnyLength) {
  Process daemon = start_sftd();
  Node node(no_daemon());
  ASSERT_TRUE(node.becomes_ready()) << node->description();
  std::vector<std::shared_ptr<core::LendingWriter>> ports;
  for (core::EndpointId id = 1; id <= 200; ++id)
    ports.push_back(node->open_writer({.id = id, .type = &frame_type()}).value());
  ASSERT_TRUE(status_becomes([](const Status& status) { return status.usage.publishers.size() == 200; }));
  for (const char* words : {"status", "status --json"}) {
    const Answer answer = call_on_full_disk(words);
    EXPECT_EQ(answer.text, "sftd: the status cannot be written: No space left on device\n") << words;
    EXPECT_EQ(answer.code, ExitCode::failed) << words;
  }
}

TEST_F(SftdCommands, ShowHowManyChunksEachPublisherHolds) {
  Process daemon = start_sftd();
  Process hoarder = start_peer({"hoard", "5", "1000"});
  ASSERT_EQ(hoarder.line(), "hoarded");
  ASSERT_TRUE(status_becomes([](const Status& status) { return status.usage.publishers.size() == 1; }));
  const Status status = status_now();
  const shm::PublisherUse& publisher = status.usage.publishers.front();
  EXPECT_EQ(publisher.publisher, "0000000000000005");
  EXPECT_EQ(publisher.held.chunks, 16U);
  EXPECT_EQ(publisher.held.bytes, 16U * (status.usage.pools[0].bytes + 40));
  EXPECT_EQ(status.usage.pools[0].in_use, 16U);
  ASSERT_EQ(status.usage.users.size(), 1U);
  EXPECT_EQ(status.usage.users[0].pid, hoarder.pid());
  EXPECT_EQ(status.usage.users[0].name, publisher.user);
  EXPECT_EQ(status.usage.users[0].publishers, 1U);
}

TEST_F(SftdCommands, ShowHowManySamplesWaitForAReaderAndHowManyItHolds) {
  Process daemon = start_sftd();
  Node node(no_daemon());
  ASSERT_TRUE(node.becomes_ready()) << node->description();
  Writer writer(node, 1);
  Reader reader(node);
  ASSERT_TRUE(reader.connects_to(1));
  for (int i = 0; i < 3; ++i) writer.send_frame();
  const core::SampleHandle held = reader.next();
  const auto shows_both = [](const Status& status) {
    const auto& readers = status.usage.subscribers;
    return readers.size() == 1 && readers[0].held.chunks == 1 && readers[0].waiting == 2;
  };
  EXPECT_TRUE(status_becomes(shows_both)) << call({"status"}).text;
  EXPECT_EQ(status_now().usage.publishers.at(0).subscribers, 1U);
}

TEST_F(SftdCommands, ShowTheMostChunksThatAPortHasHeld) {
  Process daemon = start_sftd();
  Node node(no_daemon());
  ASSERT_TRUE(node.becomes_ready()) << node->description();
  Writer writer(node, 1);
  const auto holds = [](const Status& status, std::uint32_t chunks) {
    return status.usage.publishers.size() == 1 && status.usage.publishers[0].held.chunks == chunks;
  };
  {
    std::vector<core::SampleHandle> loans(10);
    for (core::SampleHandle& loan : loans) loan = writer.loan(100);
    ASSERT_TRUE(status_becomes([&](const Status& status) { return holds(status, 10); }));
  }
  ASSERT_TRUE(status_becomes([&](const Status& status) { return holds(status, 0); }));
  EXPECT_EQ(status_now().usage.publishers[0].held.peak, 10U);
  EXPECT_EQ(status_now().usage.pools[0].peak, 10U);
}

/// Returns the size of the process's own memory in KiB ("RssAnon" in status, see proc(5)).
std::size_t own_kib(pid_t pid) {
  std::ifstream status("/proc/" + std::to_string(pid) + "/status");
  for (std::string line; std::getline(status, line);)
    if (line.starts_with("RssAnon:")) return std::stoul(line.substr(8));
  return 0;
}

TEST_F(SftdCommands, KeepNothingOfPublishersThatAreGone) {
  Process daemon = start_sftd();
  Node node(no_daemon());
  ASSERT_TRUE(node.becomes_ready()) << node->description();
  core::EndpointId id = 0;
  const auto open_and_close = [&](core::EndpointId publishers) {
    const auto opens = [&] { return node->open_writer({.id = id, .type = &frame_type()}).has_value(); };
    // The daemon takes ports back ten times a second. Until then it may have no room for more publishers.
    for (const core::EndpointId end = id + publishers; ++id <= end;) ASSERT_TRUE(eventually(opens));
  };
  open_and_close(3000);  // after this the daemon has memory for all ports that may be in use at once
  const std::size_t before = own_kib(daemon.pid());
  ASSERT_GT(before, 0U);
  open_and_close(6000);
  EXPECT_LT(own_kib(daemon.pid()), before + 1500) << "a quarter of a kilobyte of each is noise";
}

TEST_F(SftdCommands, CountDeadProgramsAndNoneThatHaveEnded) {
  Process daemon = start_sftd();
  // Keeps the daemon from restarting, as a daemon without programs does.
  Process witness = start_peer({"attend"});
  ASSERT_EQ(witness.line(), "ready");
  const auto has_users = [](std::size_t users) {
    return status_becomes([users](const Status& status) { return status.usage.users.size() == users; });
  };
  {
    Node node(no_daemon());
    ASSERT_TRUE(node.becomes_ready()) << node->description();
    ASSERT_TRUE(has_users(2));
  }
  ASSERT_TRUE(has_users(1));
  EXPECT_EQ(status_now().usage.deaths, 0U);
  Process victim = start_peer({"publish", "1", "100"});
  ASSERT_EQ(victim.line(), "publishing");
  victim.kill();
  EXPECT_TRUE(status_becomes([](const Status& status) {
    return status.usage.deaths == 1 && status.usage.users.size() == 1 && status.usage.unaudited == 0;
  }));
}

TEST_F(SftdCommands, CountTheLocksThatKilledProgramsLeftClosed) {
  Process daemon = start_sftd();
  Process witness = start_peer({"attend"});
  ASSERT_EQ(witness.line(), "ready");
  Process victim = start_peer({"lock", "1"});
  ASSERT_EQ(victim.line(), "locked");
  EXPECT_EQ(status_now().usage.locks_healed, 0U);
  victim.kill();
  EXPECT_TRUE(status_becomes([](const Status& status) { return status.usage.locks_healed == 1; }));
}

TEST_F(SftdCommands, ShowTheLastStateOfAStoppedDaemonAndSayThatItDoesNotAnswer) {
  Process daemon = start_sftd();
  Process hoarder = start_peer({"hoard", "5", "1000"});
  ASSERT_EQ(hoarder.line(), "hoarded");
  ASSERT_TRUE(status_becomes([](const Status& status) { return status.usage.publishers.size() == 1; }));
  daemon.signal(SIGSTOP);
  ASSERT_TRUE(eventually([&] { return is_stopped(daemon.pid()); }));
  const Answer answer = call({"status"});
  EXPECT_EQ(answer.code, ExitCode::no_answer);
  EXPECT_TRUE(contains(answer.text, "is stopped")) << answer.text;
  EXPECT_TRUE(contains(answer.text, "0000000000000005")) << answer.text;
}

/// A stopped daemon, and a node that requests ports from the daemon without waiting for the answers.
class PortsAnsweredLate : public SftdCommands {
 protected:
  PortsAnsweredLate() : daemon_(start_sftd()), node_(without_waiting()) {
    EXPECT_TRUE(node_.becomes_ready()) << node_->description();
    daemon_.signal(SIGSTOP);
    EXPECT_TRUE(eventually([&] { return is_stopped(daemon_.pid()); }));
  }
  void goes_on() const { daemon_.signal(SIGCONT); }
  auto asks_for(core::EndpointId writer) { return node_->open_writer({.id = writer, .type = &frame_type()}); }
  auto comes(core::EndpointId writer) {
    auto port = asks_for(writer);
    EXPECT_TRUE(eventually([&] { return port || (port = asks_for(writer)); })) << port.error().message;
    return port;
  }
  Node& node() { return node_; }
  void TearDown() override {
    daemon_.kill();
    SftdCommands::TearDown();
  }

 private:
  static shm::ShmOptions without_waiting() {
    shm::ShmOptions options = no_daemon();
    options.port_wait = 0ms;
    options.port_deadline = hang_timeout;
    return options;
  }
  Process daemon_;
  Node node_;
};

TEST_F(PortsAnsweredLate, HoldUpNoCallAndAreThereWhenTheirAnswersHaveCome) {
  EXPECT_FALSE(asks_for(1));
  EXPECT_FALSE(asks_for(2));
  EXPECT_TRUE(node()->awaits_answer());
  Reader reader(node());
  EXPECT_FALSE(reader.port().connect({.writer = 9}));
  goes_on();
  const auto first = comes(1), second = comes(2);
  EXPECT_TRUE(eventually([&] { return reader.port().connect({.writer = 9}).has_value(); }));
  EXPECT_FALSE(node()->awaits_answer());
  EXPECT_TRUE(status_becomes([](const Status& status) { return status.usage.publishers.size() == 2; }));
}

TEST_F(PortsAnsweredLate, AreGivenBackIfTheNodeDoesNotAskForThemAgain) {
  EXPECT_FALSE(asks_for(1));
  goes_on();
  ASSERT_TRUE(status_becomes([](const Status& status) { return status.usage.publishers.size() == 1; }));
  EXPECT_TRUE(status_becomes([&](const Status& status) {
    node().poll();
    return status.usage.publishers.empty();
  }));
}

TEST_F(SftdCommands, ARefusalThatComesAfterItsDeadlineAnswersNoLaterQuestion) {
  std::ofstream("/tmp/sftd.toml")
      << "total_mib = 16\nlog_level = 'error'\n[limits]\npublishers_per_process = 1\n";
  Process daemon({sftd_path(), "--foreground", "--config=/tmp/sftd.toml"});
  ASSERT_EQ(daemon.line(), "sftd: ready");
  shm::ShmOptions options = no_daemon();
  options.port_wait = 0ms;
  options.port_deadline = 50ms;
  Node node(options);
  ASSERT_TRUE(node.becomes_ready()) << node->description();
  const auto asks_for = [&](core::EndpointId writer) {
    return node->open_writer({.id = writer, .type = &frame_type()});
  };
  auto first = asks_for(1);
  ASSERT_TRUE(eventually([&] { return first || (first = asks_for(1)); })) << first.error().message;

  daemon.signal(SIGSTOP);
  ASSERT_TRUE(eventually([&] { return is_stopped(daemon.pid()); }));
  EXPECT_FALSE(asks_for(2));
  ASSERT_TRUE(eventually([&] { return !node->awaits_answer(); }));
  EXPECT_FALSE(asks_for(2)) << "it has given the question up";
  Reader reader(node);
  EXPECT_FALSE(reader.port().connect({.writer = 9}));
  daemon.signal(SIGCONT);
  EXPECT_TRUE(eventually([&] {
    const auto connected = reader.port().connect({.writer = 9});
    EXPECT_TRUE(connected || connected.error().code == Errc::unavailable) << connected.error().message;
    return connected.has_value();
  }));
}

TEST_F(SftdCommands, StopEndsTheDaemonAndNamesTheProgramsThatUsedIt) {
  Process daemon = start_sftd();
  Process user = start_peer({"attend"});
  ASSERT_EQ(user.line(), "ready");
  ASSERT_TRUE(status_becomes([](const Status& status) { return status.usage.users.size() == 1; }));
  const Answer answer = call({"stop"});
  EXPECT_EQ(answer.code, ExitCode::done);
  EXPECT_TRUE(contains(answer.text, "(pid " + std::to_string(user.pid()) + ")")) << answer.text;
  EXPECT_EQ(daemon.exit_code(), 0);
  EXPECT_TRUE(is_alive(user.pid()));
  EXPECT_EQ(call({"stop"}).code, ExitCode::not_running);
}

TEST_F(SftdCommands, StopDoesNotWaitForeverForAStoppedDaemon) {
  Process daemon = start_sftd();
  daemon.signal(SIGSTOP);
  const Answer answer = call({"stop", "--patience=0.2"});
  EXPECT_EQ(answer.code, ExitCode::no_answer);
  EXPECT_TRUE(contains(answer.text, "kill -CONT")) << answer.text;
  daemon.signal(SIGCONT);
  EXPECT_EQ(daemon.exit_code(), 0) << "the daemon has got the signal, and must end when it goes on";
}

TEST_F(SftdCommands, NoClockThatWasSetBackMakesATimeNegative) {
  Status status;
  status.since_ns = 2'000'000'000'000'000'000;
  EXPECT_TRUE(contains(to_table(status, status.since_ns - 7'000'000'000), "(00:00:00)"));
  EXPECT_TRUE(contains(to_table(status, status.since_ns + 7'000'000'000), "(00:00:07)"));
}

TEST_F(SftdCommands, AMalformedStatusIsRefused) {
  EXPECT_FALSE(shm::parse_status(""));
  EXPECT_FALSE(shm::parse_status("{\"pid\": \"many\"}"));
  EXPECT_FALSE(shm::parse_status("[1, 2"));
  EXPECT_FALSE(shm::parse_status("{\"usage\": {\"pools\": 3}}"));
}

TEST_F(SftdCommands, AStatusIsReadBackAsItWasWritten) {
  Status status;
  status.pid = 42;
  // A name that is no UTF-8, because programs choose their names.
  status.usage.users = {{7, "sft_\xff_7", 1, 2}};
  status.usage.publishers = {{"sft_a_7", "01", 3, {4, 5, 6}}};
  const auto read = shm::parse_status(shm::to_json(status));
  ASSERT_TRUE(read);
  EXPECT_EQ(read->pid, 42);
  EXPECT_EQ(read->usage.users.at(0).subscribers, 2U);
  EXPECT_EQ(read->usage.publishers.at(0).held.bytes, 6U);
}

}  // namespace
}  // namespace sft::test
