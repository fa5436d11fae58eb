// A request may come before the announcement of its reader, and by several links.
#include <gmock/gmock.h>

#include <vector>

#include "tests/unit/core/discovery/link_merge_fixture.h"

namespace sft::core {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST_F(LinkMergeTest, KeepsARequestThatComesBeforeItsReader) {
  asks(by_lan, 4);
  asks(stranger, 99);
  announces(by_lan, 1);
  EXPECT_THAT(told(), ElementsAre("honest 1 by 11", "request 4 by 11"));
}

TEST_F(LinkMergeTest, KeepsOfEachOnlyItsLastRequestThatComesBeforeItsReader) {
  for (std::uint64_t sequence = 1; sequence <= 10; ++sequence) asks(by_lan, sequence);
  announces(by_lan, 1);
  EXPECT_THAT(told(), ElementsAre("honest 1 by 11", "request 10 by 11"));
}

TEST_F(LinkMergeTest, KeepsRequestsOfFourThatComeBeforeAReaderAndNoMore) {
  for (AnnouncerId one = 21; one <= 25; ++one) asks({lan, one}, 4);
  asks({lan, 24}, 5);
  announces({lan, 25}, 1);
  EXPECT_THAT(told(), ElementsAre("honest 1 by 25"));
  merge.endpoint_withdrawn({lan, 25}, 5, now);
  announces({lan, 24}, 2);
  EXPECT_THAT(told(), ElementsAre("departed", "honest 2 by 24", "request 5 by 24"));
}

TEST_F(LinkMergeTest, KeepsSoManyRequestsThatComeBeforeTheirReadersAndTheLastOnes) {
  LinkMerge small({.early_requests = 2});
  for (EndpointId id = 5; id <= 7; ++id) small.request_came(by_lan, request(2, id), now);
  for (EndpointId id = 5; id <= 7; ++id) small.endpoint_came(by_lan, endpoint(1, "honest", id), now);
  std::vector<EndpointId> asked;
  for (const News& news : small.take_news()) {
    if (const auto* one = std::get_if<Request>(&news)) asked.push_back(one->reader);
  }
  EXPECT_THAT(asked, ElementsAre(6, 7));
}

TEST_F(LinkMergeTest, ForgetsRequestsWhoseReaderDoesNotCome) {
  asks(by_lan, 4);
  passes(61s);
  announces(by_lan, 1);
  EXPECT_THAT(told(), ElementsAre("honest 1 by 11"));
}

TEST_F(LinkMergeTest, ForgetsRequestsWithTheLinkByWhichTheyCame) {
  asks(by_radio, 4);
  merge.link_dropped(radio, now);
  announces(by_radio, 1);
  EXPECT_THAT(told(), ElementsAre("honest 1 by 12"));
}

TEST_F(LinkMergeTest, TellsNoOlderRequestOfAnotherLinkThanWasToldBefore) {
  announces(by_lan, 1);
  announces(by_radio, 1);
  asks(by_lan, 5);
  passes(3s, {by_radio});
  told();
  asks(by_radio, 4);
  EXPECT_THAT(told(), IsEmpty());
  asks(by_radio, 6);
  EXPECT_THAT(told(), ElementsAre("request 6 by 12"));
}

}  // namespace
}  // namespace sft::core
