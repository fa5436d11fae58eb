// Endpoints are announced under keys that are used again, since Cyclone DDS never forgets a key.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "core/discovery/heard_keys.h"
#include "core/discovery/own_keys.h"

namespace sft::core {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::UnorderedElementsAre;

TEST(OwnKeysTest, AnEndpointHasTheSameKeyUntilItIsReleased) {
  OwnKeys keys;
  const std::uint64_t key = keys.key_of(1);
  EXPECT_EQ(keys.key_of(1), key);
  EXPECT_NE(keys.key_of(2), key);
  EXPECT_EQ(keys.release(1), key);
  EXPECT_EQ(keys.release(1), std::nullopt);
}

TEST(OwnKeysTest, TenThousandEndpointsOfWhichTwoAreThereAtATimeHaveTwoKeys) {
  OwnKeys keys;
  std::set<std::uint64_t> used{keys.key_of(1), keys.key_of(2)};
  for (EndpointId id = 3; id < 10'000; ++id) {
    keys.release(id - 2);
    used.insert(keys.key_of(id));
  }
  EXPECT_EQ(used.size(), 2U);
}

TEST(OwnKeysTest, TwoProcessesHaveDifferentKeys) {
  OwnKeys one, other;
  EXPECT_NE(one.key_of(1), other.key_of(1));
}

constexpr Participants::Guid first_guid{1}, second_guid{2};

TEST(HeardKeysTest, AnotherEndpointUnderTheKeyEndsTheOneBefore) {
  HeardKeys keys;
  EXPECT_EQ(keys.announced(first_guid, 7, 10), std::nullopt);
  EXPECT_EQ(keys.announced(first_guid, 7, 10), std::nullopt) << "it is announced again";
  EXPECT_EQ(keys.announced(first_guid, 7, 11), 10U);
  EXPECT_EQ(keys.withdrawn(first_guid, 7), 11U);
  EXPECT_EQ(keys.withdrawn(first_guid, 7), std::nullopt);
  EXPECT_EQ(keys.announced(first_guid, 7, 12), std::nullopt) << "the one before has been withdrawn";
}

TEST(HeardKeysTest, AParticipantEndsNoEndpointOfAnotherByUsingItsKey) {
  HeardKeys keys;
  keys.announced(first_guid, 7, 10);
  EXPECT_EQ(keys.announced(second_guid, 7, 66), std::nullopt);
  EXPECT_EQ(keys.withdrawn(first_guid, 7), 10U);
}

TEST(HeardKeysTest, AWithdrawalByAParticipantThatHasAnnouncedNothingNamesTheEndpointOfAnotherParticipant) {
  HeardKeys keys;
  keys.announced(first_guid, 7, 10);
  EXPECT_EQ(keys.withdrawn(second_guid, 7), 10U);
  EXPECT_EQ(keys.withdrawn(first_guid, 7), 10U) << "it is still there";
  EXPECT_EQ(keys.withdrawn(second_guid, 7), std::nullopt);
}

TEST(HeardKeysTest, AKeyThatNoParticipantWritesAnyMoreEndsTheEndpointsOfAll) {
  HeardKeys keys;
  keys.announced(first_guid, 7, 10);
  keys.announced(second_guid, 7, 66);
  keys.announced(first_guid, 8, 11);
  EXPECT_THAT(keys.unheard(7), UnorderedElementsAre(10, 66));
  EXPECT_THAT(keys.unheard(7), IsEmpty());
  EXPECT_THAT(keys.unheard(8), ElementsAre(11));
}

TEST(HeardKeysTest, AParticipantThatIsGoneIsForgotten) {
  HeardKeys keys;
  keys.announced(first_guid, 7, 10);
  keys.announced(second_guid, 7, 66);
  keys.forget(first_guid);
  EXPECT_THAT(keys.unheard(7), ElementsAre(66));
}

}  // namespace
}  // namespace sft::core
