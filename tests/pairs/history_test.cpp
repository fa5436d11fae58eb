// Row "History" of negotiation.md: samples that a publisher retains for late readers.
#include "tests/pairs/fixture.h"

namespace sft::test {
namespace {

const json retaining{{"transient_local", true}, {"history_depth", 5}};
const json asking{{"transient_local", true}};

class LateReaders : public NegotiationTest {
 protected:
  /// Publishes 20 samples. The publisher retains the last 5.
  static void fill(Peer& publisher) {
    publisher.advertise(retaining);
    publisher.publish(20);
  }
  static bool has_what_was_retained(Peer& publisher, Peer& reader) {
    return comes_true([&] {
      const json taken = taken_of(publisher, reader);
      return !taken.is_null() && taken["first"] == 16 && taken["last"] == 20;
    });
  }
};

/// Returns the options with UDP switched off.
json in_memory(json options) {
  options["transport"] = "shm";
  return options;
}

TEST_F(LateReaders, OnAnotherHostGetWhatIsRetainedUnderTheirMaskAndThenWhatIsPublished) {
  Peer publisher(here(), "publisher");
  Peer reader(there(), "reader");
  fill(publisher);
  reader.subscribe("height, width", asking);
  ASSERT_TRUE(has_what_was_retained(publisher, reader)) << reader.status();
  publisher.publish(50);
  EXPECT_TRUE(agree(publisher, reader));
  EXPECT_TRUE(accounts_for_all(publisher, reader));
  EXPECT_EQ(writer_of(publisher, reader)["lost"], 0);
  EXPECT_EQ(taken_of(publisher, reader)["masks"].size(), 1);
}

TEST_F(LateReaders, WithoutUdpGetWhatIsRetainedInSharedMemoryAlsoOfTheTimeBeforeTheDaemonAndOnlyOnce) {
  Peer publisher(here(), "publisher");
  Peer reader(here(), "reader");
  publisher.advertise(in_memory(retaining));
  publisher.publish(20);
  reader.subscribe("height, width", in_memory(asking));
  std::optional<Daemon> daemon(std::in_place, here());
  ASSERT_TRUE(has_what_was_retained(publisher, reader)) << reader.status();
  ASSERT_TRUE(agree(publisher, reader));
  publisher.publish(50);
  EXPECT_TRUE(accounts_for_all(publisher, reader));
  EXPECT_EQ(writer_of(publisher, reader)["lost"], 0);
  daemon.reset();
  ASSERT_TRUE(comes_true([&] { return !is_served(publisher, reader); }));
  daemon.emplace(here());
  ASSERT_TRUE(comes_true([&] { return is_served(publisher, reader); }));
  EXPECT_TRUE(accounts_for_all(publisher, reader)) << "something came twice";
}

TEST_F(LateReaders, WithoutUdpMissNothingAndTakeNothingTwiceWherePublishingGoesOn) {
  const Daemon daemon(here());
  Peer publisher(here(), "publisher");
  Peer early(here(), "early");
  publisher.advertise(in_memory(retaining));
  early.subscribe("data");
  // A reader's queue has 256 places, so a reader that does not run for half a second loses nothing.
  publisher.start_publishing(2ms);
  ASSERT_TRUE(comes_true([&] { return is_served_by(publisher, early, "shm"); }));
  for (int round = 0; round < 10; ++round) {
    Peer reader(here(), "reader_" + std::to_string(round));
    reader.subscribe("data", in_memory(asking));
    ASSERT_TRUE(comes_true([&] {
      const json taken = taken_of(publisher, reader);
      return !taken.is_null() && taken["received"] > 50;
    })) << reader.status();
    const json status = reader.status();
    EXPECT_EQ(status["subscriber"]["lost"], 0) << status;
    const json& taken = status["taken"][0];
    EXPECT_EQ(taken["disordered"], 0);
  }
}

class LateReadersBeside : public LateReaders {
 protected:
  /// Starts a publisher and a late reader on one host with a daemon.
  void SetUp() override {
    LateReaders::SetUp();
    if (IsSkipped()) return;
    daemon.emplace(here());
    publisher.emplace(here(), "publisher");
    reader.emplace(here(), "reader", with_short_lease());
    for (Peer* peer : {&*publisher, &*reader})
      ASSERT_TRUE(comes_true([&] { return peer->status()["node"]["shm_ready"]; }));
    fill(*publisher);
    reader->subscribe("height, width", asking);
    ASSERT_TRUE(has_what_was_retained(*publisher, *reader)) << reader->status();
    EXPECT_EQ(taken_of(*publisher, *reader)["by_shm"], 0);
    ASSERT_TRUE(comes_true([&] { return is_served_by(*publisher, *reader, "shm"); }));
    ASSERT_TRUE(agree(*publisher, *reader));
  }

  std::optional<Daemon> daemon;
  std::optional<Peer> publisher, reader;
};

TEST_F(LateReadersBeside, GetWhatIsRetainedByUdpAndChangeOverToSharedMemoryThen) {
  publisher->publish(50);
  EXPECT_TRUE(accounts_for_all(*publisher, *reader));
  EXPECT_GE(taken_of(*publisher, *reader)["by_shm"], 50);
  EXPECT_EQ(writer_of(*publisher, *reader)["lost"], 0);
}

TEST_F(LateReadersBeside, ThatAreLostAndReturnAreNotGivenItAgain) {
  reader->signal(SIGSTOP);
  ASSERT_TRUE(comes_true([&] { return !is_served(*publisher, *reader); }));
  publisher->publish(20);
  reader->signal(SIGCONT);
  ASSERT_TRUE(agree(*publisher, *reader));
  EXPECT_TRUE(accounts_for_all(*publisher, *reader));
  EXPECT_EQ(writer_of(*publisher, *reader)["lost"], 20);
}

}  // namespace
}  // namespace sft::test
