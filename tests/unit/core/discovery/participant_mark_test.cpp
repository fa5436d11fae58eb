// These tests read the user data of participants, and data that make no sense.
#include "core/discovery/participant_mark.h"

#include <gtest/gtest.h>

#include <random>

namespace sft::core {
namespace {

Participants::Guid guid(std::uint8_t first) {
  Participants::Guid guid{};
  for (std::size_t i = 0; i < guid.size(); ++i) guid[i] = static_cast<std::uint8_t>(first + 17 * i);
  return guid;
}

TEST(ParticipantMarkTest, IsReadAsItWasWritten) {
  ParticipantMark mark{.greeting = 7};
  EXPECT_EQ(parse_participant_mark(to_text(mark)), mark);
  mark.is_secured = true;
  for (std::uint8_t i = 0; i <= complaints_max; ++i) {
    EXPECT_EQ(parse_participant_mark(to_text(mark)), mark);
    if (i < complaints_max) mark.complaints.push_back(guid(i));
  }
}

TEST(ParticipantMarkTest, OneWithoutComplaintsIsThatOfEarlierReleases) {
  EXPECT_EQ(to_text({.greeting = 3}), "sft/14/3");
  EXPECT_EQ(to_text({.greeting = 13}), "sft/14/3");
  EXPECT_EQ(to_text({.greeting = 3, .is_secured = true}), "sft/14/3s");
}

TEST(ParticipantMarkTest, OthersUserDataAreNone) {
  for (const char* data : {"", "sft", "sft/7/3", "sft/99/3", "SFT/9/3", "enclave=/;"})
    EXPECT_FALSE(parse_participant_mark(data)) << data;
}

TEST(ParticipantMarkTest, TheVersionOfAnotherReleaseIsRead) {
  EXPECT_EQ(other_version("sft/7/3"), 7U);
  EXPECT_EQ(other_version("sft/8/"), 8U);
  EXPECT_EQ(other_version("sft/15/3s!0123"), 15U);
  EXPECT_EQ(other_version("sft/9999/\n"), 9999U);
}

TEST(ParticipantMarkTest, OnlyAnotherVersionCountsAsAnotherRelease) {
  EXPECT_FALSE(other_version(to_text({})));
  for (const char* data :
       {"", "sft", "sft/", "sft//3", "sft/7", "sft/-7/3", "sft/+7/3", "sft/ 7/3", "sft/07/3", "sft/0/3",
        "sft/7x/3", "sft/99999/3", "sft/18446744073709551623/", "SFT/7/3", "enclave=/;"})
    EXPECT_FALSE(other_version(data)) << data;
}

TEST(ParticipantMarkTest, ComplaintsThatMakeNoSenseAreLeftOut) {
  const std::string sound = to_text({.complaints = {guid(1)}}).substr(std::string("sft/14/0").size());
  for (const std::string& nonsense :
       {std::string("!"), std::string("!!!"), std::string("!0123"), "!" + std::string(32, 'x'),
        "!" + std::string(33, '0'), "!+1" + std::string(30, '0'), "! 1" + std::string(30, '0')}) {
    const auto mark = parse_participant_mark("sft/14/0" + nonsense + sound + nonsense);
    ASSERT_TRUE(mark) << nonsense;
    EXPECT_EQ(mark->complaints, std::vector{guid(1)}) << nonsense;
  }
}

TEST(ParticipantMarkTest, TakesNoMoreComplaintsThanThereMayBe) {
  std::string text = "sft/14/0";
  for (int i = 0; i < 1000; ++i) text += "!" + std::string(32, 'a');
  EXPECT_EQ(parse_participant_mark(text)->complaints.size(), complaints_max);
}

}  // namespace
}  // namespace sft::core
