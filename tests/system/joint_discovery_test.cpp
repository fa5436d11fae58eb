// The nodes of a process share discovery. Nevertheless each node discovers other nodes, and is discovered
// by them.
#include <dds/dds.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "core/discovery/heartbeat_socket.h"
#include "core/sync/mutex.h"
#include "tests/support/eventually.h"
#include "tests/support/isolated_host.h"
#include "tests/system/control_reader.h"

namespace sft::test {
namespace {

using core::Role;
using ::testing::ElementsAre;

/// Counts the readers and writers of a control topic on this host that Cyclone reports.
class TopicMonitor {
 public:
  explicit TopicMonitor(std::string topic) : topic_(std::move(topic)) {
    readers_ = dds_create_reader(participant_.entity(), DDS_BUILTIN_TOPIC_DCPSSUBSCRIPTION, nullptr, nullptr);
    writers_ = dds_create_reader(participant_.entity(), DDS_BUILTIN_TOPIC_DCPSPUBLICATION, nullptr, nullptr);
  }

  bool readers_become(std::size_t wanted) const { return become(readers_, wanted); }
  bool writers_become(std::size_t wanted) const { return become(writers_, wanted); }

 private:
  /// Waits for that number of endpoints. Since Cyclone reports endpoints one after the other, the function
  /// then checks for a while that no more endpoints are reported.
  bool become(dds_entity_t builtin, std::size_t wanted) const {
    return eventually([&] { return count(builtin) == wanted; }) &&
           !eventually([&] { return count(builtin) > wanted; }, std::chrono::milliseconds(200));
  }
  std::size_t count(dds_entity_t builtin) const {
    std::size_t endpoints = 0;
    constexpr std::size_t room = 256;
    std::vector<void*> samples(room, nullptr);
    std::vector<dds_sample_info_t> infos(room);
    const dds_return_t n = dds_read(builtin, samples.data(), infos.data(), room, room);
    for (std::size_t i = 0; n > 0 && i < static_cast<std::size_t>(n); ++i) {
      const auto& endpoint = *static_cast<const dds_builtintopic_endpoint_t*>(samples[i]);
      if (infos[i].instance_state == DDS_IST_ALIVE && infos[i].valid_data && endpoint.topic_name == topic_)
        ++endpoints;
    }
    if (n > 0) dds_return_loan(builtin, samples.data(), n);
    return endpoints;
  }

  const std::string topic_;
  const LoopbackParticipant participant_;
  dds_entity_t readers_ = 0, writers_ = 0;
};

/// Counts the announcements of participants of this host that Cyclone reports.
class ParticipantMonitor {
 public:
  ParticipantMonitor()
      : reader_(
            dds_create_reader(participant_.entity(), DDS_BUILTIN_TOPIC_DCPSPARTICIPANT, nullptr, nullptr)) {}

  int words() {
    void* sample = nullptr;
    dds_sample_info_t info;
    while (dds_take(reader_, &sample, &info, 1, 1) == 1) {
      ++words_;
      dds_return_loan(reader_, &sample, 1);
    }
    return words_;
  }

 private:
  const LoopbackParticipant participant_;
  const dds_entity_t reader_;
  int words_ = 0;
};

class JointDiscoveryTest : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!isolation_refusal().empty()) GTEST_SKIP() << isolation_refusal();
  }
};

TEST_F(JointDiscoveryTest, HasOneReaderAndOneWriterOfATopicHoweverManyNodesShareIt) {
  std::vector<std::unique_ptr<ControlReader>> nodes;
  for (core::EndpointId id = 1; id <= 8; ++id) {
    nodes.push_back(std::make_unique<ControlReader>("one-"));
    nodes.back()->announce(Role::reader, id);
  }
  ControlReader other("two-");
  other.announce(Role::writer, 100);
  other.announce(Role::reader, 101);
  for (const auto& node : nodes) EXPECT_TRUE(node->hears(100));
  const TopicMonitor of_writers("sft_writer"), of_readers("sft_reader");
  EXPECT_TRUE(of_writers.readers_become(2));
  EXPECT_TRUE(of_writers.writers_become(1));
  EXPECT_TRUE(of_readers.readers_become(1));
  EXPECT_TRUE(of_readers.writers_become(2));
}

TEST_F(JointDiscoveryTest, ExchangesReportsOnlyWhileANodeInquires) {
  ControlReader writer("one-"), reader("two-");
  const TopicMonitor reports("sft_report");
  const core::Inquiry inquiry{.topic = "points"};
  writer.announce(Role::writer, 1);
  reader.announce(Role::reader, 2);
  EXPECT_TRUE(reader.hears(1) && writer.hears(2));
  writer.report({.living = {1}});
  EXPECT_TRUE(reports.writers_become(0)) << "no node has asked";
  reader.inquire({inquiry});
  EXPECT_TRUE(writer.is_asked(inquiry));
  EXPECT_TRUE(reports.readers_become(1));
  EXPECT_TRUE(eventually([&] {
    writer.report({.living = {1}});
    return reader.reports() > 0;
  }));
  EXPECT_TRUE(reports.writers_become(1));
  reader.inquire({});
  EXPECT_TRUE(reports.readers_become(0));
  EXPECT_TRUE(writer.is_asked_nothing());
  writer.look();
  EXPECT_TRUE(reports.writers_become(0));
}

TEST_F(JointDiscoveryTest, TellsANewcomerOfTheProcessWhatIsInForce) {
  ControlReader first("one-"), other("two-");
  first.announce(Role::writer, 1);
  other.announce(Role::reader, 2);
  other.announce(Role::reader, 3);
  other.ask(2, 7);
  EXPECT_TRUE(first.hears(2) && first.hears(3));
  EXPECT_TRUE(eventually([&] { return first.asked() == 7; }));
  other.withdraw(3);
  EXPECT_TRUE(eventually([&] { return !first.heard().contains(3); }));

  ControlReader newcomer("one-");
  newcomer.announce(Role::writer, 4);
  EXPECT_TRUE(newcomer.hears(2));
  EXPECT_TRUE(eventually([&] { return newcomer.asked() == 7; }));
  EXPECT_THAT(newcomer.heard(), ElementsAre(2));
  EXPECT_TRUE(other.hears(1) && other.hears(4));
}

TEST_F(JointDiscoveryTest, LetsNodesOfTheProcessHearEachOther) {
  ControlReader writer("one-"), reader("one-");
  writer.announce(Role::writer, 1);
  reader.announce(Role::reader, 2);
  EXPECT_TRUE(reader.hears(1) && writer.hears(2));
  ControlReader newcomer("one-");
  newcomer.announce(Role::reader, 3);
  EXPECT_TRUE(newcomer.hears(1) && writer.hears(3));
  writer.withdraw(1);
  EXPECT_TRUE(eventually([&] { return reader.heard().empty() && newcomer.heard().empty(); }));
}

TEST_F(JointDiscoveryTest, AnnouncesItselfToAStrangerOfWhichOnlyHeartbeatsCome) {
  using namespace std::chrono_literals;
  ControlReader control_reader("one-");
  ParticipantMonitor participants;
  const auto announces_within = [&](std::chrono::milliseconds duration, const auto& meanwhile) {
    const int words = participants.words();
    const auto has_announced = [&] {
      meanwhile();
      control_reader.look();
      return participants.words() > words;
    };
    return eventually(has_announced, duration);
  };
  // At the start, participants announce themselves with shorter pauses than this.
  const auto is_quiet = [&] { return !announces_within(2500ms, [] {}); };
  ASSERT_TRUE(eventually(is_quiet, 30s)) << "the announcements at the start end";

  const auto stranger =
      core::HeartbeatSocket::open({.ip = core::loopback_ipv4, .reaches_own_host = true, .index = 1},
                                  *core::dds_config(control_domain(), {}, "")->heartbeat_port);
  ASSERT_TRUE(stranger);
  EXPECT_TRUE(announces_within(10s, [&] { stranger->send({.participant = {7}, .process = 77}); }));
}

TEST_F(JointDiscoveryTest, StaysWithTheOtherNodesWhenTheFirstOneGoes) {
  auto first = std::make_unique<ControlReader>("one-");
  ControlReader second("one-"), third("one-"), other("two-");
  first->announce(Role::reader, 1);
  second.announce(Role::reader, 2);
  third.announce(Role::reader, 3);
  other.announce(Role::writer, 10);
  EXPECT_TRUE(second.hears(10) && third.hears(10) && other.hears(1));

  first->withdraw(1);
  first.reset();
  EXPECT_TRUE(eventually([&] { return other.heard() == std::set<core::EndpointId>{2, 3}; }));
  other.announce(Role::writer, 11);
  EXPECT_TRUE(second.hears(11) && third.hears(11));
  EXPECT_THAT(second.heard(), ElementsAre(10, 11));
  EXPECT_THAT(third.heard(), ElementsAre(10, 11));
  EXPECT_EQ(second.gone() + third.gone(), 0U) << "nobody is lost meanwhile";
  other.withdraw(10);
  EXPECT_TRUE(eventually([&] { return !second.heard().contains(10) && !third.heard().contains(10); }));
  EXPECT_TRUE(TopicMonitor("sft_writer").readers_become(1));
}

// The two configurations are equal except for the number of the domain.
TEST_F(JointDiscoveryTest, IsNotSharedByNodesWhoseUserGivesTheDomainAnotherNumber) {
  const auto numbered = [](int domain) {
    return "<CycloneDDS><Domain id=\"any\"><Discovery><ExternalDomainId>" + std::to_string(domain) +
           "</ExternalDomainId></Discovery></Domain></CycloneDDS>";
  };
  ControlReader here("", numbered(70)), elsewhere("", numbered(71)), also_here("", numbered(70));
  here.announce(Role::writer, 1);
  elsewhere.announce(Role::reader, 2);
  also_here.announce(Role::reader, 3);
  EXPECT_TRUE(also_here.hears(1) && here.hears(3));
  EXPECT_THAT(here.heard(), ElementsAre(3));
  EXPECT_TRUE(elsewhere.heard().empty());
}

TEST_F(JointDiscoveryTest, OfAProgramThatOpenedTheDomainItselfMeetsTheOtherProcessesOfItsHost) {
  const pid_t program = fork();
  ASSERT_GE(program, 0);
  if (program == 0) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    dds_create_participant(control_domain(), nullptr, nullptr);
    ControlReader writer;
    writer.announce(Role::writer, 1);
    for (;;) pause();
  }
  ControlReader reader;
  reader.announce(Role::reader, 2);
  EXPECT_TRUE(reader.hears(1));
  kill(program, SIGKILL);
  waitpid(program, nullptr, 0);
}

TEST_F(JointDiscoveryTest, CarriesTwoHundredNodesInOneProcess) {
  ControlReader other("two-");
  other.announce(Role::writer, 1000);
  std::vector<std::unique_ptr<ControlReader>> nodes;
  std::set<core::EndpointId> writers{1000}, readers;
  for (core::EndpointId id = 1; id <= 200; ++id) {
    nodes.push_back(std::make_unique<ControlReader>("one-"));
    const bool is_writer = id % 2 == 0;
    nodes.back()->announce(is_writer ? Role::writer : Role::reader, id);
    (is_writer ? writers : readers).insert(id);
  }
  EXPECT_TRUE(eventually([&] { return other.heard() == readers; })) << other.heard().size();
  for (core::EndpointId id = 1; id <= 200; ++id) {
    const auto& others = id % 2 == 0 ? readers : writers;
    EXPECT_TRUE(eventually([&] { return nodes[id - 1]->heard() == others; })) << id;
  }
  EXPECT_TRUE(TopicMonitor("sft_writer").writers_become(2));
  nodes.clear();
  EXPECT_TRUE(eventually([&] { return other.heard().empty(); })) << other.heard().size();
}

TEST_F(JointDiscoveryTest, OutlivesNodesThatComeAndGo) {
  ControlReader other("two-");
  other.announce(Role::writer, 1000);
  std::vector<std::unique_ptr<ControlReader>> nodes;
  for (core::EndpointId id = 1; id <= 40; ++id) {
    nodes.push_back(std::make_unique<ControlReader>("one-"));
    nodes.back()->announce(Role::reader, id);
    EXPECT_TRUE(nodes.back()->hears(1000)) << id;
    if (nodes.size() <= 3) continue;
    nodes.front()->withdraw(id - 3);
    nodes.erase(nodes.begin());
  }
  EXPECT_TRUE(eventually([&] { return other.heard() == std::set<core::EndpointId>{38, 39, 40}; }));
}

}  // namespace
}  // namespace sft::test
