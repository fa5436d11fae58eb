// These tests check which request of a reader of another node is in force.
#include "core/negotiation/remote_requests.h"

#include <gtest/gtest.h>

namespace sft::core {
namespace {

class RemoteRequestsTest : public ::testing::Test {
 protected:
  static constexpr AnnouncerId its_own = 11, another = 12;
  RemoteRequestsTest() {
    reader.id = 5;
    reader.announcer = its_own;
    reader.request = request(10, its_own);
  }
  static Request request(std::uint64_t sequence, AnnouncerId announcer, EndpointId reader = 5) {
    Request r;
    r.reader = reader;
    r.sequence = sequence;
    r.announcer = announcer;
    return r;
  }

  Endpoint reader;
  RemoteRequests requests{2};
};

TEST_F(RemoteRequestsTest, OnlyANewerRequestIsAdopted) {
  EXPECT_FALSE(RemoteRequests::adopt(reader, request(9, its_own)));
  EXPECT_FALSE(RemoteRequests::adopt(reader, request(10, its_own)));
  EXPECT_TRUE(RemoteRequests::adopt(reader, request(11, another)));
  EXPECT_EQ(reader.request.sequence, 11U);
}

TEST_F(RemoteRequestsTest, ARequestFarAheadIsAdoptedOnlyFromTheReadersOwnAnnouncer) {
  const std::uint64_t far = 10 + RemoteRequests::jump_max + 1;
  EXPECT_FALSE(RemoteRequests::adopt(reader, request(far, another)));
  EXPECT_TRUE(RemoteRequests::adopt(reader, request(far, its_own)));
}

TEST_F(RemoteRequestsTest, ARequestBeyondTheGreatestSequenceIsNotAdopted) {
  reader.request.sequence = request_sequence_max;
  EXPECT_FALSE(RemoteRequests::adopt(reader, request(request_sequence_max + 1, its_own)));
}

TEST_F(RemoteRequestsTest, AKeptRequestIsAdoptedOnceTheReaderIsThere) {
  requests.keep(request(12, its_own));
  requests.adopt_early(reader);
  EXPECT_EQ(reader.request.sequence, 12U);
  requests.keep(request(13, its_own));
  requests.forget(reader.id);
  requests.adopt_early(reader);
  EXPECT_EQ(reader.request.sequence, 12U);
}

TEST_F(RemoteRequestsTest, RequestsThatWereAdoptedReplacedOrForgottenLeaveRoomForOthers) {
  for (EndpointId id = 1; id <= 100; ++id) {
    Endpoint newcomer = reader;
    newcomer.id = id;
    requests.keep(request(11, its_own, id));
    requests.keep(request(12, its_own, id));
    requests.adopt_early(newcomer);
    EXPECT_EQ(newcomer.request.sequence, 12U);
    requests.keep(request(13, its_own, id));
    requests.keep(request(13, another, id));
    requests.forget(id);
  }
  EXPECT_EQ(requests.dropped(), 0U);
}

TEST_F(RemoteRequestsTest, ARequestThatGivesWayToAnotherOneIsCounted) {
  for (EndpointId id = 1; id <= 3; ++id) requests.keep(request(1, its_own, id));
  EXPECT_EQ(requests.dropped(), 1U);
}

}  // namespace
}  // namespace sft::core
