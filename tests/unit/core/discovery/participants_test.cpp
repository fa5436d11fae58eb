// Participants have numbers, and tags by which pulses name them.
#include "core/discovery/participants.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <map>
#include <utility>

namespace sft::core {
namespace {

using ::testing::Optional;

Participants::Guid guid(std::uint64_t number) {
  Participants::Guid guid{};
  std::memcpy(guid.data(), &number, sizeof number);
  return guid;
}

TEST(ParticipantsTest, AParticipantIsFoundByItsTagOnceItIsKnown) {
  Participants participants;
  EXPECT_FALSE(participants.tagged(Participants::tag_of(guid(1))));
  const AnnouncerId number = participants.number_of(guid(1));
  EXPECT_THAT(participants.tagged(Participants::tag_of(guid(1))), Optional(number));
  EXPECT_FALSE(participants.tagged(Participants::tag_of(guid(2))));
}

TEST(ParticipantsTest, OfTwoParticipantsWithOneTagTheFirstIsFound) {
  std::map<std::uint32_t, std::uint64_t> by_tag;
  std::uint64_t second = 0;
  while (by_tag.try_emplace(Participants::tag_of(guid(second)), second).second) ++second;
  const std::uint64_t first = by_tag.at(Participants::tag_of(guid(second)));
  Participants participants;
  const AnnouncerId number = participants.number_of(guid(first));
  EXPECT_NE(participants.number_of(guid(second)), number);
  EXPECT_THAT(participants.tagged(Participants::tag_of(guid(second))), Optional(number));
}

TEST(ParticipantsTest, AParticipantThatIsLongGoneIsForgotten) {
  Participants participants;
  const AnnouncerId number = participants.number_of(guid(0));
  participants.gone(guid(0));
  EXPECT_EQ(participants.number_of(guid(0)), number) << "it may come back";
  for (std::uint64_t other = 1; other <= 1024; ++other) {
    participants.number_of(guid(other));
    participants.gone(guid(other));
  }
  EXPECT_FALSE(participants.guid_of(number));
  EXPECT_FALSE(participants.tagged(Participants::tag_of(guid(0))));
  EXPECT_TRUE(participants.tagged(Participants::tag_of(guid(1))));
}

}  // namespace
}  // namespace sft::core
