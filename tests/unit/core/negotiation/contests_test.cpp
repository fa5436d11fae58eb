// These tests check which words of others in the name of our endpoint make us announce it anew.
#include "core/negotiation/contests.h"

#include <gmock/gmock.h>

#include "core/negotiation/remote_requests.h"

namespace sft::core {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

class ContestsTest : public ::testing::Test {
 protected:
  ContestsTest() {
    ours.id = 200;
    ours.role = Role::reader;
    ours.node = "ours";
    ours.revision = 3;
    ours.request.reader = 200;
    ours.request.sequence = 5;
  }
  std::string how() {
    std::string all;
    for (const Contests::Contested& contested : contests.take()) all += contested.how;
    return all;
  }

  Endpoint ours;
  Contests contests;
};

TEST_F(ContestsTest, ACopyOfWhatWeSaidIsNoContest) {
  Endpoint copy = ours;
  copy.announcer = 99;
  copy.request.announcer = 99;
  contests.announced(ours, copy);
  contests.requested(ours, copy.request);
  EXPECT_THAT(how(), IsEmpty());
}

TEST_F(ContestsTest, AnotherAnnouncementIsAnsweredByARevisionAndARequestThatAreLater) {
  Endpoint said = ours;
  said.node = "forger";
  said.revision = 9;
  said.request.sequence = 20;
  contests.announced(ours, said);
  EXPECT_EQ(ours.revision, 9U) << "the next announcement is one later";
  EXPECT_EQ(ours.request.sequence, 21U);
  EXPECT_THAT(how(), HasSubstr("who calls the node 'forger'"));
  EXPECT_THAT(how(), IsEmpty()) << "it is told once";
}

TEST_F(ContestsTest, ANumberFarBeyondOursIsNotOvertaken) {
  Request said = ours.request;
  said.sequence += RemoteRequests::jump_max + 1;
  contests.requested(ours, said);
  EXPECT_EQ(ours.request.sequence, 6U);
  EXPECT_THAT(how(), HasSubstr("is asked for something"));
}

TEST_F(ContestsTest, AWriterThatIsWithdrawnKeepsItsRequest) {
  ours.role = Role::writer;
  contests.withdrawn(ours);
  EXPECT_EQ(ours.request.sequence, 5U);
  EXPECT_THAT(how(), HasSubstr("was withdrawn"));
}

}  // namespace
}  // namespace sft::core
