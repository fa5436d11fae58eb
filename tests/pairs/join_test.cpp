// Rows "Join", "Leave" and "Limits" of negotiation.md: nodes that start and end in an orderly way.
#include "tests/pairs/fixture.h"

namespace sft::test {
namespace {

class JoinAndLeave : public NegotiationTest {};

TEST_F(JoinAndLeave, AReaderThatComesLaterIsSentNothingBeforeItAsksAndEverythingFromThenOn) {
  Peer publisher(here(), "publisher");
  Peer reader(there(), "reader");
  publisher.advertise();
  publisher.publish(20);
  EXPECT_EQ(publisher.status()["publisher"]["bytes_sent"], 0);
  reader.subscribe("height, width");
  ASSERT_TRUE(agree(publisher, reader));
  publisher.publish(100);
  EXPECT_TRUE(accounts_for_all(publisher, reader));
  EXPECT_EQ(taken_of(publisher, reader)["first"], 21);
  EXPECT_EQ(writer_of(publisher, reader)["lost"], 0);
}

TEST_F(JoinAndLeave, AReaderThatIsThereFirstGetsEverythingFromWhenItIsServed) {
  Peer reader(there(), "reader");
  reader.subscribe("data");
  Peer publisher(here(), "publisher");
  publisher.advertise();
  ASSERT_TRUE(agree(publisher, reader));
  publisher.publish(100);
  EXPECT_TRUE(accounts_for_all(publisher, reader));
  EXPECT_EQ(taken_of(publisher, reader)["first"], 1);
  EXPECT_EQ(writer_of(publisher, reader)["lost"], 0);
}

TEST_F(JoinAndLeave, NoDatagramComesToAReaderThatDoesNotListenYet) {
  Peer publisher(here(), "publisher");
  publisher.advertise();
  publisher.start_publishing(200us);
  for (int i = 0; i < 10; ++i) {
    Peer reader(there(), "reader_" + std::to_string(i));
    reader.subscribe("height, width");
    ASSERT_TRUE(comes_true([&] { return !taken_of(publisher, reader).is_null(); }));
    EXPECT_EQ(reader.status()["node"]["datagrams_unknown"], 0);
  }
}

TEST_F(JoinAndLeave, AReaderThatIsAnnouncedAgainKeepsTheMaskThatItAskedForLater) {
  Peer publisher(here(), "publisher");
  Peer reader(there(), "reader");
  publisher.advertise();
  reader.subscribe("recorded");
  reader.read("height");
  publisher.start_publishing();
  ASSERT_TRUE(comes_true([&] { return is_served_with(publisher, reader, "height"); }));
  const Daemon daemon(there());  // changes the host token in the announcements
  ASSERT_TRUE(comes_true([&] { return reader.status()["node"]["shm_ready"]; }));
  publisher.stop_publishing();
  EXPECT_TRUE(agree(publisher, reader));
  EXPECT_TRUE(is_served_with(publisher, reader, "height"));
  EXPECT_TRUE(accounts_for_all(publisher, reader));
}

TEST_F(JoinAndLeave, AReaderThatIsDestroyedSaysSoAndIsUnknownWithoutALease) {
  Peer publisher(here(), "publisher");
  Peer reader(there(), "reader");
  publisher.advertise();
  reader.subscribe("data");
  ASSERT_TRUE(agree(publisher, reader));
  reader.leave();
  EXPECT_TRUE(comes_true([&] { return reader_of(publisher, reader).is_null(); }));
  EXPECT_TRUE(gets_event(publisher, "offered", "unmatched", "the other side has left"));
  const json sent = publisher.status()["publisher"]["bytes_sent"];
  publisher.publish(10);
  EXPECT_EQ(publisher.status()["publisher"]["bytes_sent"], sent);
}

TEST_F(JoinAndLeave, AProcessThatEndsTakesItsEndpointsWithIt) {
  Peer publisher(here(), "publisher");
  Peer reader(there(), "reader");
  Peer other(there(), "other");
  publisher.advertise();
  reader.subscribe("data");
  other.subscribe("data");
  ASSERT_TRUE(agree(publisher, reader));
  ASSERT_TRUE(agree(publisher, other));
  EXPECT_EQ(reader.quit(), 0);
  EXPECT_TRUE(comes_true([&] { return reader_of(publisher, reader).is_null(); }));
  EXPECT_TRUE(gets_event(publisher, "offered", "unmatched", "the other side has left"));
  EXPECT_TRUE(accounts_for_all(publisher, other));
  EXPECT_EQ(publisher.quit(), 0);
  EXPECT_TRUE(comes_true([&] { return writer_of(publisher, other).is_null(); }));
  EXPECT_TRUE(gets_event(other, "requested", "unmatched", "the other side has left"));
}

TEST_F(JoinAndLeave, WhatAPublisherSentJustBeforeItLeftIsTakenAndThenItIsAskedNoMore) {
  Peer publisher(here(), "publisher");
  Peer reader(there(), "reader");
  publisher.advertise();
  reader.subscribe("*");
  ASSERT_TRUE(agree(publisher, reader));
  const std::uint64_t requests = reader.status()["subscriber"]["requests"];
  publisher.publish(100, 200us);
  publisher.leave();
  EXPECT_TRUE(comes_true([&] {
    const json status = reader.status();
    return status["subscriber"]["writers"].empty() && status["subscriber"]["requests"] > requests;
  }));
  EXPECT_TRUE(comes_true([&] { return reader.status()["subscriber"]["received"] == 100; }))
      << reader.status();
  EXPECT_EQ(reader.status()["taken"][0]["wrong"], 0);
}

/// The limit is the 4,096 records of one process (PeerLimits). A process without readers reads no records of
/// publishers.
TEST_F(JoinAndLeave, EndpointsBeyondTheLimitAreCountedAndThoseBelowItStayServed) {
  Peer publisher(here(), "publisher");
  Peer reader(there(), "reader");
  publisher.advertise();
  reader.subscribe("data");
  ASSERT_TRUE(agree(publisher, reader));
  reader.look_around();
  Peer many_publishers(there(), "many");
  many_publishers.many_publishers(4100);
  EXPECT_TRUE(comes_true([&] { return reader.status()["node"]["control_ignored"] > 0; }));
  EXPECT_TRUE(agree(publisher, reader));
  EXPECT_EQ(publisher.status()["node"]["control_ignored"], 0);
  publisher.publish(10);
  EXPECT_TRUE(accounts_for_all(publisher, reader));
}

}  // namespace
}  // namespace sft::test
