// Two containers of one machine, which share their network stack, /dev/shm and /tmp, or have their own. These
// are the rows of the table in shm_transport/host/same_host.md.
#include <filesystem>
#include <set>
#include <string>
#include <system_error>

#include "tests/pairs/fixture.h"

namespace sft::test {
namespace {

/// Returns the process ids of the daemons in all containers.
std::set<pid_t> daemons() {
  std::set<pid_t> found;
  for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
    std::error_code none;
    const auto program = std::filesystem::read_symlink(entry.path() / "exe", none);
    if (program.filename() == "sftd") found.insert(std::stoi(entry.path().filename()));
  }
  return found;
}

bool kill_daemons() {
  for (const pid_t daemon : daemons()) kill(daemon, SIGKILL);
  return daemons().empty();
}

class Islands : public NegotiationTest, public testing::WithParamInterface<Host::Shared> {
 protected:
  /// Kills the daemons, because they outlive the nodes that started them.
  void TearDown() override {
    if (IsSkipped()) return;
    EXPECT_TRUE(comes_true(kill_daemons));
  }

  static bool share_memory() { return GetParam().shm && GetParam().tmp; }
  /// Returns the expected number of daemons: one for each /dev/shm. If /tmp is shared, there is only one,
  /// because only one daemon can have its sockets there.
  static std::size_t daemons_wanted() { return GetParam().shm || GetParam().tmp ? 1 : 2; }
  /// Returns the reason that a node reports if the containers do not share both /dev/shm and /tmp.
  static std::string cause() {
    return GetParam().shm   ? "another /tmp than sftd"
           : GetParam().tmp ? "another /dev/shm"
                            : "a /dev/shm of its own";
  }

  /// Returns true if the expected number of daemons runs, each node uses one of them or reports the reason
  /// why not, and the reader is served by the right transport.
  static bool are_settled(Peer& publisher, Peer& reader) {
    const std::set<pid_t> running = daemons();
    if (running.size() != daemons_wanted()) return false;
    std::size_t served = 0;
    for (Peer* peer : {&publisher, &reader}) {
      const std::string state = peer->status()["node"]["shm"];
      const auto names = [&](pid_t pid) {
        return state.find("(pid " + std::to_string(pid) + ")") != state.npos;
      };
      const bool in_memory = state.starts_with("iceoryx") && std::ranges::any_of(running, names);
      if (!in_memory && state.find(cause()) == std::string::npos) return false;
      served += in_memory ? 1 : 0;
    }
    return served == (daemons_wanted() == 2 || share_memory() ? 2U : 1U) &&
           is_served_by(publisher, reader, share_memory() ? "shm" : "udp");
  }

  static testing::AssertionResult settle(Peer& publisher, Peer& reader) {
    if (comes_true([&] { return are_settled(publisher, reader); })) return agree(publisher, reader);
    return testing::AssertionFailure()
           << daemons().size() << " daemons; " << publisher.status() << reader.status();
  }

  static bool both_name_the_reason(Peer& publisher, Peer& reader) {
    const std::string here = reader_of(publisher, reader)["reason"];
    const std::string there = writer_of(publisher, reader)["reason"];
    if (share_memory()) return here == "same host" && there == "same host";
    return here.find(cause()) != here.npos || there.find(cause()) != there.npos;
  }
};

TEST_P(Islands, UseTheMemoryThatTheyShareOrUdpAndSayWhyAlsoAfterTheirDaemonIsKilled) {
  const Host container(here(), GetParam());
  const json options{{"start_daemon", true}};
  Peer publisher(here(), "publisher", options);
  Peer reader(container, "reader", options);
  publisher.advertise();
  reader.subscribe("data");
  ASSERT_TRUE(settle(publisher, reader));
  EXPECT_TRUE(comes_true([&] { return both_name_the_reason(publisher, reader); }))
      << publisher.status() << reader.status();
  publisher.publish(100);
  EXPECT_TRUE(accounts_for_all(publisher, reader));
  EXPECT_EQ(taken_of(publisher, reader)["by_shm"] > 0, share_memory());

  publisher.start_publishing();
  kill_daemons();
  ASSERT_TRUE(settle(publisher, reader));
  publisher.stop_publishing();
  EXPECT_TRUE(comes_true([&] { return both_name_the_reason(publisher, reader); }))
      << publisher.status() << reader.status();
  EXPECT_TRUE(accounts_for_all(publisher, reader));
}

TEST_P(Islands, HaveNoSecondDaemonOnHalfOfTheMemoryOfAnotherOne) {
  const Host container(here(), GetParam());
  const Daemon daemon(here());
  Peer probe(here(), "probe");
  ASSERT_TRUE(comes_true([&] { return probe.status()["node"]["shm_ready"]; }));
  Daemon second(container);
  if (daemons_wanted() == 1) {
    EXPECT_EQ(second.wait_for_end(), share_memory() ? 0 : 3);
  } else {
    Peer beside(container, "beside");
    EXPECT_TRUE(comes_true([&] { return beside.status()["node"]["shm_ready"]; }));
  }
  EXPECT_TRUE(probe.status()["node"]["shm_ready"]);
}

std::string name_of(const testing::TestParamInfo<Host::Shared>& info) {
  const auto [network, shm, tmp] = info.param;
  return std::string(network ? "SharedNetwork" : "OwnNetwork") + (shm ? "SharedShm" : "OwnShm") +
         (tmp ? "SharedTmp" : "OwnTmp");
}

std::vector<Host::Shared> all_combinations() {
  std::vector<Host::Shared> all;
  for (const bool network : {true, false}) {
    for (const bool shm : {true, false}) {
      for (const bool tmp : {true, false}) all.push_back({network, shm, tmp});
    }
  }
  return all;
}
INSTANTIATE_TEST_SUITE_P(Containers, Islands, testing::ValuesIn(all_combinations()), name_of);

}  // namespace
}  // namespace sft::test
