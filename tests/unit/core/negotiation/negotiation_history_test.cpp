// Tests of late readers: which of these readers get earlier samples, and when they change over to shared
// memory.
#include <gtest/gtest.h>

#include "tests/unit/core/negotiation/negotiation_fixture.h"

namespace sft::core {
namespace {

class LateReaderTest : public NegotiationTest {
 protected:
  LateReaderTest() {
    Endpoint writer = endpoint(Role::writer, 100);
    writer.qos = {.durability = transient_local, .history_depth = 5};
    negotiation.local_added(writer, type);
  }
  /// Returns a reader on this host that is attached in shared memory.
  Endpoint late_reader(EndpointId id = 7) {
    Endpoint reader = endpoint(Role::reader, id, here, 1);
    reader.qos = {.durability = transient_local, .history_depth = 3};
    reader.request.attached = {100};
    return reader;
  }
  /// Returns the request of a reader whose retained samples have begun to arrive.
  Request begun(EndpointId reader, std::uint64_t sequence) {
    Request with_history = request(reader, sequence, F::data, {100});
    with_history.begun = {100};
    return with_history;
  }
  void begin(EndpointId reader, std::uint64_t sequence) {
    negotiation.request_received(begun(reader, sequence));
  }
};

TEST_F(LateReaderTest, GetsByUdpWhatBothSidesKeepAndChangesOverToSharedMemoryThen) {
  negotiation.endpoint_seen(late_reader());
  Serving serving = negotiation.serving(100);
  EXPECT_TRUE(serving.memory.empty());
  ASSERT_EQ(serving.network.size(), 1U);
  EXPECT_EQ(serving.network[0].history, 3U);
  EXPECT_TRUE(serving.history_owed);
  EXPECT_FALSE(negotiation.history_given(100, 7)) << "nothing of it has come yet";
  begin(7, 2);
  EXPECT_TRUE(negotiation.serving(100).history_owed) << "not all of it has left yet";
  EXPECT_TRUE(negotiation.history_given(100, 7));
  EXPECT_FALSE(negotiation.history_given(100, 7));
  serving = negotiation.serving(100);
  EXPECT_TRUE(serving.network.empty());
  EXPECT_EQ(serving.memory.size(), 1U);
  EXPECT_FALSE(serving.history_owed);
}

TEST_F(LateReaderTest, GetsThroughSharedMemoryAloneWhatBothSidesKeepUntilItSaysThatItHas) {
  Endpoint reader = late_reader();
  reader.may_use_network = false;
  negotiation.endpoint_seen(reader);
  Serving serving = negotiation.serving(100);
  EXPECT_EQ(serving.memory.at(0).history, 3U);
  EXPECT_EQ(serving.readers.at(0).reason, "same host");
  begin(7, 2);
  EXPECT_EQ(negotiation.serving(100).memory.at(0).history, 0U);
}

TEST_F(LateReaderTest, ThatIsVolatileGetsNothing) {
  Endpoint reader = late_reader();
  reader.qos.durability = volatile_;
  negotiation.endpoint_seen(reader);
  EXPECT_EQ(negotiation.serving(100).memory.size(), 1U);
}

TEST_F(LateReaderTest, ThatWasLostAndReturnsIsNotGivenItAgainAndOneThatWentIs) {
  negotiation.endpoint_seen(late_reader());
  begin(7, 2);
  negotiation.history_given(100, 7);
  negotiation.endpoint_lost(7, Time{});
  Endpoint returned = late_reader();
  returned.request = begun(7, 2);
  negotiation.endpoint_seen(returned);
  EXPECT_EQ(negotiation.serving(100).memory.size(), 1U);
  negotiation.endpoint_departed(7);
  negotiation.endpoint_seen(late_reader());
  EXPECT_EQ(negotiation.serving(100).network.size(), 1U);
}

TEST_F(LateReaderTest, ThatLostUsAndFoundUsAgainIsGivenItAgain) {
  negotiation.endpoint_seen(late_reader());
  begin(7, 2);
  negotiation.history_given(100, 7);
  negotiation.request_received(request(7, 3, F::data, {100}));
  EXPECT_TRUE(negotiation.serving(100).history_owed);
  begin(7, 4);
  EXPECT_TRUE(negotiation.serving(100).history_owed) << "it has begun, but not all of it has left yet";
}

TEST_F(NegotiationTest, OurReaderIsAttachedOnlyOnceTheHistoryHasCome) {
  Endpoint reader = endpoint(Role::reader, 200);
  reader.qos.durability = transient_local;
  negotiation.local_added(reader, type);
  Endpoint writer = endpoint(Role::writer, 7, here, 1);
  writer.qos.durability = transient_local;
  negotiation.endpoint_seen(writer);
  EXPECT_FALSE(negotiation.hearing(200).at(0).memory);
  EXPECT_EQ(negotiation.hearing(200).at(0).status.reason, "same host; retained samples come first, by UDP");
  negotiation.history_began(200, 7);
  EXPECT_FALSE(negotiation.hearing(200).at(0).memory);
  EXPECT_TRUE(negotiation.history_came(200, 7));
  EXPECT_FALSE(negotiation.history_came(200, 7));
  EXPECT_TRUE(negotiation.hearing(200).at(0).memory);
}

class OurLateReaderTest : public NegotiationTest {
 protected:
  OurLateReaderTest() {
    Endpoint reader = endpoint(Role::reader, 200);
    reader.qos.durability = transient_local;
    negotiation.local_added(reader, type);
    Endpoint writer = endpoint(Role::writer, 7, here, 1);
    writer.qos.durability = transient_local;
    negotiation.endpoint_seen(writer);
  }
  void changed(bool listening, bool attached) { negotiation.connection_changed(200, 7, listening, attached); }
  bool has_begun() const { return !negotiation.local(200)->request.begun.empty(); }
};

TEST_F(OurLateReaderTest, IsOwedTheHistoryAgainOnceThePathIsGoneThatItCameBy) {
  changed(true, false);
  negotiation.history_began(200, 7);
  negotiation.history_came(200, 7);
  changed(true, true);
  changed(true, false);
  EXPECT_TRUE(has_begun()) << "it came by UDP, which is there still";
  EXPECT_TRUE(negotiation.hearing(200).at(0).memory);
  changed(false, false);
  EXPECT_FALSE(has_begun());
  EXPECT_FALSE(negotiation.hearing(200).at(0).memory);
}

TEST_F(OurLateReaderTest, IsOwedTheHistoryAgainOnceSharedMemoryIsGoneThatItCameBy) {
  changed(false, true);
  negotiation.history_began(200, 7);
  changed(false, false);
  EXPECT_FALSE(has_begun());
}

TEST_F(NegotiationTest, OurReaderTakesNothingOfADurableWriterBeforeTheRetainedSamples) {
  Endpoint reader = endpoint(Role::reader, 200);
  reader.qos.durability = transient_local;
  negotiation.local_added(reader, type);
  Endpoint writer = endpoint(Role::writer, 7);
  negotiation.endpoint_seen(writer);
  EXPECT_FALSE(negotiation.hearing(200).at(0).source.history_first);
  writer.qos.durability = transient_local;
  negotiation.endpoint_seen(writer);
  EXPECT_TRUE(negotiation.hearing(200).at(0).source.history_first);
  EXPECT_TRUE(negotiation.history_began(200, 7));
  EXPECT_FALSE(negotiation.history_began(200, 7));
  EXPECT_EQ(negotiation.local(200)->request.begun, std::vector<EndpointId>{7});
  negotiation.connection_changed(200, 7, true, false);
  negotiation.connection_changed(200, 7, false, false);
  EXPECT_TRUE(negotiation.local(200)->request.begun.empty());
}

}  // namespace
}  // namespace sft::core
