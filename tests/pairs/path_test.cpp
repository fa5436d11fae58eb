// Rows "Host token changes" and "Path changes" of negotiation.md, and the paths in its table of pairs.
// Daemons start and end, or the hosts have different daemons.
#include "tests/pairs/fixture.h"

namespace sft::test {
namespace {

class Paths : public NegotiationTest {
 protected:
  static bool goes_by(Peer& publisher, Peer& reader, const std::string& transport) {
    return comes_true([&] { return is_served_by(publisher, reader, transport); });
  }
  static bool has_reason(Peer& publisher, Peer& reader, const std::string& reason) {
    return reader_of(publisher, reader)["reason"].get<std::string>().starts_with(reason);
  }
  static bool is_refused_for(Peer& publisher, Peer& reader, const std::string& reason) {
    return comes_true([&] {
      const json entry = reader_of(publisher, reader);
      return !entry.is_null() && !entry["served"] && entry["reason"].get<std::string>().starts_with(reason);
    });
  }
};

TEST_F(Paths, ChangeWithTheDaemonAndNothingIsTakenTwiceOrUnderAnotherMask) {
  Peer publisher(here(), "publisher");
  Peer reader(here(), "reader");
  publisher.advertise();
  reader.subscribe("recorded");
  reader.read("height");
  publisher.start_publishing();
  ASSERT_TRUE(comes_true([&] { return is_served_with(publisher, reader, "height"); }));
  for (int i = 0; i < 2; ++i) {
    EXPECT_TRUE(is_served_by(publisher, reader, "udp"));
    const json received = writer_of(publisher, reader)["received"];
    ASSERT_TRUE(comes_true([&] { return writer_of(publisher, reader)["received"] > received; }));
    // Includes the samples that were lost when the daemon ended.
    const json lost = writer_of(publisher, reader)["lost"];
    Daemon daemon(here());
    ASSERT_TRUE(goes_by(publisher, reader, "shm"));
    EXPECT_TRUE(agree(publisher, reader));
    EXPECT_EQ(writer_of(publisher, reader)["lost"], lost) << "it was not attached yet";
    EXPECT_TRUE(is_served_with(publisher, reader, "height"));
    daemon.kill_now();
    ASSERT_TRUE(goes_by(publisher, reader, "udp"));
    EXPECT_TRUE(agree(publisher, reader));
    EXPECT_TRUE(is_served_with(publisher, reader, "height"));
  }
  publisher.stop_publishing();
  EXPECT_TRUE(accounts_for_all(publisher, reader));
  EXPECT_EQ(taken_of(publisher, reader)["last_mask"], "height");
  for (const char* path : {"shm: same host", "udp: "}) {
    EXPECT_TRUE(gets_event(publisher, "offered", "path changed", path));
    EXPECT_TRUE(gets_event(reader, "requested", "path changed", path));
  }
}

TEST_F(Paths, OfAReaderElsewhereIsUdpWhileThatOfAReaderBesideIsSharedMemory) {
  const Daemon ours(here());
  const Daemon theirs(there());
  Peer publisher(here(), "publisher");
  Peer beside(here(), "beside");
  Peer elsewhere(there(), "elsewhere");
  publisher.advertise();
  beside.subscribe("data");
  elsewhere.subscribe("height, width");
  ASSERT_TRUE(goes_by(publisher, beside, "shm"));
  ASSERT_TRUE(comes_true([&] { return elsewhere.status()["node"]["shm_ready"]; }));
  for (Peer* reader : {&beside, &elsewhere}) ASSERT_TRUE(agree(publisher, *reader));
  EXPECT_TRUE(has_reason(publisher, elsewhere, "another host"));
  publisher.publish(100);
  for (Peer* reader : {&beside, &elsewhere}) {
    EXPECT_TRUE(accounts_for_all(publisher, *reader));
    EXPECT_EQ(writer_of(publisher, *reader)["lost"], 0);
  }
  EXPECT_EQ(taken_of(publisher, elsewhere)["by_shm"], 0);
}

TEST_F(Paths, OfContainersOnOneNetworkStackIsUdpSinceTheirMemoryIsNotTheSame) {
  const Host container(here(), {.network = true});
  const Daemon ours(here());
  const Daemon theirs(container);
  Peer publisher(here(), "publisher");
  Peer reader(container, "reader");
  publisher.advertise();
  reader.subscribe("data");
  for (Peer* peer : {&publisher, &reader})
    ASSERT_TRUE(comes_true([&] { return peer->status()["node"]["shm_ready"]; }));
  ASSERT_TRUE(agree(publisher, reader));
  EXPECT_TRUE(comes_true([&] { return has_reason(publisher, reader, "another host or container"); }));
  publisher.publish(100);
  EXPECT_TRUE(accounts_for_all(publisher, reader));
  EXPECT_EQ(taken_of(publisher, reader)["by_shm"], 0);
  EXPECT_EQ(writer_of(publisher, reader)["lost"], 0);
}

TEST_F(Paths, WithoutUdpThereIsNoneUntilSharedMemoryIsThere) {
  Peer publisher(here(), "publisher");
  Peer reader(here(), "reader");
  publisher.advertise({{"transport", "shm"}});
  reader.subscribe("height, width", {{"transport", "shm"}});
  ASSERT_TRUE(is_refused_for(publisher, reader, "UDP is ruled out, and no shared memory: "));
  publisher.publish(10);
  const Daemon daemon(here());
  ASSERT_TRUE(goes_by(publisher, reader, "shm"));
  ASSERT_TRUE(agree(publisher, reader));
  publisher.publish(50);
  EXPECT_TRUE(accounts_for_all(publisher, reader));
  EXPECT_EQ(taken_of(publisher, reader)["first"], 11);
  EXPECT_EQ(writer_of(publisher, reader)["lost"], 0);
}

TEST_F(Paths, WithoutUdpThereIsNoneToAnotherHost) {
  const Daemon ours(here());
  const Daemon theirs(there());
  Peer publisher(here(), "publisher");
  Peer reader(there(), "reader");
  publisher.advertise();
  reader.subscribe("*", {{"transport", "shm"}});
  EXPECT_TRUE(is_refused_for(publisher, reader, "UDP is ruled out, and another host"));
  publisher.publish(10);
  EXPECT_TRUE(reader.status()["taken"].empty());
}

TEST_F(Paths, ThatOneSideWantsAndTheOtherRulesOutAreNone) {
  const Daemon daemon(here());
  Peer publisher(here(), "publisher");
  Peer reader(here(), "reader");
  publisher.advertise({{"transport", "udp"}});
  reader.subscribe("*", {{"transport", "shm"}});
  EXPECT_TRUE(is_refused_for(publisher, reader, "UDP is ruled out, and the publisher "));
  EXPECT_TRUE(comes_true([&] {
    const json writer = writer_of(publisher, reader);
    return !writer.is_null() && !writer["matched"] &&
           writer["reason"].get<std::string>().starts_with("UDP is ruled out, and the publisher ");
  })) << reader.status();
  publisher.publish(10);
  EXPECT_TRUE(reader.status()["taken"].empty());
}

TEST_F(Paths, LeadThroughSharedMemoryOnceADaemonThatDidNotAnswerAnswersAgain) {
  const Daemon daemon(here());
  Peer publisher(here(), "publisher");
  Peer reader(here(), "reader");
  for (Peer* each : {&publisher, &reader})
    ASSERT_TRUE(comes_true([&] { return each->status()["node"]["shm_ready"].get<bool>(); }));
  daemon.signal(SIGSTOP);
  publisher.advertise({{"transport", "shm"}});
  reader.subscribe("data", {{"transport", "shm"}});
  ASSERT_TRUE(is_refused_for(publisher, reader, "shared memory is being attached"));
  daemon.signal(SIGCONT);
  ASSERT_TRUE(goes_by(publisher, reader, "shm"));
  publisher.publish(10);
  EXPECT_TRUE(accounts_for_all(publisher, reader));
  EXPECT_EQ(writer_of(publisher, reader)["lost"], 0);
}

TEST_F(Paths, AReaderThatIsKilledInSharedMemoryIsServedNoMoreAndCostsOthersNothing) {
  const Daemon daemon(here());
  Peer publisher(here(), "publisher");
  Peer killed(here(), "killed", with_short_lease());
  Peer reader(here(), "reader");
  publisher.advertise();
  killed.subscribe("*");
  reader.subscribe("data");
  for (Peer* each : {&killed, &reader}) ASSERT_TRUE(goes_by(publisher, *each, "shm"));
  ASSERT_TRUE(agree(publisher, reader));
  publisher.start_publishing();
  killed.kill_now();
  EXPECT_TRUE(comes_true([&] { return !is_served(publisher, killed); }));
  publisher.stop_publishing();
  EXPECT_TRUE(agree(publisher, reader));
  EXPECT_TRUE(accounts_for_all(publisher, reader));
  EXPECT_EQ(writer_of(publisher, reader)["lost"], 0);
}

TEST_F(Paths, AReaderThatIsStoppedInSharedMemoryIsServedAgainWhenItContinues) {
  const Daemon daemon(here());
  Peer publisher(here(), "publisher");
  Peer reader(here(), "reader", with_short_lease());
  publisher.advertise();
  reader.subscribe("data");
  ASSERT_TRUE(goes_by(publisher, reader, "shm"));
  publisher.start_publishing();
  reader.signal(SIGSTOP);
  EXPECT_TRUE(comes_true([&] { return !is_served(publisher, reader); }));
  reader.signal(SIGCONT);
  EXPECT_TRUE(goes_by(publisher, reader, "shm"));
  publisher.stop_publishing();
  EXPECT_TRUE(agree(publisher, reader));
  EXPECT_TRUE(accounts_for_all(publisher, reader));
}

}  // namespace
}  // namespace sft::test
