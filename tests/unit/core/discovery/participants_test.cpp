// Participants have numbers, and tags by which pulses name them.
#include "core/discovery/participants.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>

namespace sft::core {
namespace {

using ::testing::Optional;

Participants::Guid participant(std::uint64_t number) {
  Participants::Guid guid{};
  std::memcpy(guid.data(), &number, sizeof number);
  return guid;
}

TEST(ParticipantsTest, AParticipantIsFoundByItsTagOnceItIsKnown) {
  Participants participants;
  EXPECT_FALSE(participants.tagged(Participants::tag_of(participant(1))));
  const AnnouncerId number = participants.number_of(participant(1));
  EXPECT_THAT(participants.tagged(Participants::tag_of(participant(1))), Optional(number));
  EXPECT_FALSE(participants.tagged(Participants::tag_of(participant(2))));
}

TEST(ParticipantsTest, OfTwoParticipantsWithOneTagTheFirstIsFound) {
  constexpr std::uint64_t first = 56948505, second = 67108869;
  ASSERT_EQ(Participants::tag_of(participant(first)), Participants::tag_of(participant(second)));
  Participants participants;
  const AnnouncerId number = participants.number_of(participant(first));
  EXPECT_NE(participants.number_of(participant(second)), number);
  EXPECT_THAT(participants.tagged(Participants::tag_of(participant(second))), Optional(number));
}

TEST(ParticipantsTest, AParticipantThatIsLongGoneIsForgotten) {
  Participants participants;
  const AnnouncerId number = participants.number_of(participant(0));
  participants.gone(participant(0));
  EXPECT_EQ(participants.number_of(participant(0)), number) << "it may come back";
  for (std::uint64_t other = 1; other <= 1024; ++other) {
    participants.number_of(participant(other));
    participants.gone(participant(other));
  }
  EXPECT_FALSE(participants.guid_of(number));
  EXPECT_FALSE(participants.tagged(Participants::tag_of(participant(0))));
  EXPECT_TRUE(participants.tagged(Participants::tag_of(participant(1))));
}

}  // namespace
}  // namespace sft::core
