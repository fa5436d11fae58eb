// Somebody who is not their node speaks for endpoints on the control topics.
#include <gtest/gtest.h>

#include "tests/unit/core/negotiation/negotiation_fixture.h"

namespace sft::core {
namespace {

constexpr AnnouncerId forger = 2;

/// Our reader 200 and, in a second negotiation, the writer 100 that serves it; what ours announces is carried
/// to the other by the test.
class Contests : public NegotiationTest {
 protected:
  Contests() {
    our_reader();
    negotiation.connection_changed(200, 100, TransportKind::udp, true);
    there.self_changed({.host = token(2), .network = elsewhere, .memory_state = "off"});
    there.local_added(endpoint(Role::writer, 100), type);
    announce();
  }

  void announce() {
    Endpoint said = *negotiation.next_announcement(200);
    said.announcer = said.request.announcer = honest;
    there.endpoint_seen(said);
  }
  void send() {
    Request said = negotiation.local(200)->request;
    said.announcer = honest;
    there.request_received(said);
  }
  /// Takes the contested endpoints back, as the reconciler does. Returns how many there were.
  std::size_t take_back() {
    const auto contested = negotiation.take_contested();
    if (!contested.empty()) announce();
    if (!contested.empty()) send();
    return contested.size();
  }
  /// Gives the forged request to both negotiations.
  void forge(Request request) {
    request.announcer = forger;
    there.request_received(request);
    negotiation.request_received(request);
  }
  void forge(Endpoint endpoint) {
    endpoint.announcer = endpoint.request.announcer = forger;
    there.endpoint_seen(endpoint);
    negotiation.endpoint_seen(endpoint);
  }
  bool served() const { return there.serving(100).network.size() == 1; }
  bool served_as_asked() const {
    const Serving serving = there.serving(100);
    return serving.network.size() == 1 &&
           serving.network[0].selection.mask() == FieldMask(F::height | F::width);
  }

  Negotiation there;
};

TEST_F(Contests, AReaderThatIsWithdrawnBySomebodyElseIsServedAgainOnceItAnnouncesItself) {
  ASSERT_TRUE(served_as_asked());
  there.endpoint_departed(200);
  negotiation.endpoint_departed(200);
  EXPECT_FALSE(served());
  EXPECT_EQ(take_back(), 1U);
  EXPECT_TRUE(served_as_asked());
  EXPECT_EQ(take_back(), 0U) << "it is told once";
}

TEST_F(Contests, ARequestInItsNameIsOutbid) {
  for (const std::uint64_t ahead : {1U, 2U, 1000U, 0xffff'ffffU}) {
    forge(request(200, negotiation.local(200)->request.sequence + ahead, F::data));
    EXPECT_FALSE(served_as_asked()) << "that is what has to be mended";
    EXPECT_EQ(take_back(), 1U);
    EXPECT_TRUE(served_as_asked()) << ahead;
  }
}

TEST_F(Contests, ARequestWithTheSameSequenceIsOutbid) {
  Request forged = request(200, negotiation.local(200)->request.sequence, F::data);
  EXPECT_EQ(forged.listening, negotiation.local(200)->request.listening);
  negotiation.request_received(forged);
  EXPECT_EQ(take_back(), 1U);
  EXPECT_GT(negotiation.local(200)->request.sequence, forged.sequence);
}

TEST_F(Contests, ARequestFarBeyondAllOthersCountsOnlyIfItsOwnNodeSendsIt) {
  const std::uint64_t far = negotiation.local(200)->request.sequence + RemoteRequests::jump_max + 1;
  for (const std::uint64_t sequence : {far, request_sequence_max}) {
    forge(request(200, sequence, F::data));
    EXPECT_TRUE(served_as_asked());
    EXPECT_EQ(take_back(), 1U);
    EXPECT_TRUE(served_as_asked());
    EXPECT_LT(negotiation.local(200)->request.sequence, far) << "it does not follow there";
  }
  Request own = request(200, far, F::data);
  own.announcer = honest;
  EXPECT_TRUE(there.request_received(own));
  Request beyond = request(200, request_sequence_max + 1, F::data);
  beyond.announcer = honest;
  EXPECT_FALSE(there.request_received(beyond));
}

TEST_F(Contests, AnEndpointThatIsAnnouncedDifferentlyIsAnnouncedAsItIs) {
  Endpoint forged = *negotiation.local(200);
  forged.topic = "elsewhere";
  for (const std::uint64_t ahead : {0U, 1U, 5U}) {
    forged.revision = negotiation.local(200)->revision + ahead;
    forge(forged);
    EXPECT_FALSE(served());
    EXPECT_EQ(take_back(), 1U);
    EXPECT_TRUE(served_as_asked()) << ahead;
  }
}

TEST_F(Contests, WhatAnotherNodeAskedForDoesNotOutliveItsAnnouncement) {
  Endpoint forged = *negotiation.local(200);
  forged.node_id += 1;
  forged.announcer = forged.request.announcer = forger;
  forged.request.sequence += 1000;
  forged.request.mask_words = {1};
  there.endpoint_seen(forged);
  EXPECT_FALSE(served_as_asked());
  Endpoint own = *negotiation.local(200);
  own.announcer = own.request.announcer = honest;
  there.endpoint_seen(own);
  EXPECT_TRUE(served_as_asked());
}

TEST_F(Contests, ARevisionFarBeyondAllOthersIsNoReasonToRefuseThose) {
  Endpoint forged = *negotiation.local(200);
  forged.topic = "elsewhere";
  forged.revision = UINT64_MAX;
  forged.request.sequence = request_sequence_max;
  forge(forged);
  EXPECT_FALSE(served());
  EXPECT_EQ(take_back(), 1U);
  EXPECT_TRUE(served_as_asked());
}

TEST_F(Contests, AForgedRequestThatComesBeforeTheReaderIsNotInForceLonger) {
  Negotiation late;
  late.self_changed({.host = token(2), .network = elsewhere, .memory_state = "off"});
  late.local_added(endpoint(Role::writer, 100), type);
  for (const std::uint64_t sequence : {negotiation.local(200)->request.sequence + 5, request_sequence_max}) {
    Request forged = request(200, sequence, F::data);
    forged.announcer = forger;
    late.request_received(forged);
    negotiation.request_received(forged);
  }
  there = late;
  announce();
  take_back();
  EXPECT_TRUE(served_as_asked());
}

TEST_F(Contests, ACopyOfWhatWasSaidIsNothingToAnswer) {
  const Endpoint old = *negotiation.local(200);
  const Request before = old.request;
  negotiation.requirement_changed(200, FieldMask(F::data));
  announce();
  negotiation.endpoint_seen(old);
  negotiation.request_received(before);
  negotiation.endpoint_seen(*negotiation.local(200));
  negotiation.request_received(negotiation.local(200)->request);
  EXPECT_EQ(take_back(), 0U);
}

TEST_F(Contests, AnOldAnnouncementThatComesLateTakesNothingBack) {
  Endpoint old = *negotiation.local(200);
  old.announcer = old.request.announcer = honest;
  announce();
  old.addresses.clear();
  EXPECT_FALSE(there.endpoint_seen(old));
  EXPECT_TRUE(served_as_asked());
}

}  // namespace
}  // namespace sft::core
