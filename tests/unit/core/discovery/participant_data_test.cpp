// The user data of a participant name the process of the participant. Participants of other releases are
// reported.
#include "core/discovery/participant_data.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace sft::core {
namespace {

using ::testing::EndsWith;
using ::testing::Optional;
using ::testing::StartsWith;

const std::string this_release = "sft/" + std::to_string(control_protocol_version()) + "/";

TEST(ParticipantDataTest, ComeAsTheyWereSaid) {
  for (const bool is_so : {false, true}) {
    const ParticipantData data{
        .process = 0x123, .is_secured = is_so, .uses_topic = !is_so, .asks = is_so, .count = 7};
    EXPECT_THAT(parse_participant_data(to_text(data)), Optional(data));
  }
}

TEST(ParticipantDataTest, HaveTheFormThatIsDocumented) {
  const ParticipantData data{
      .process = 0x123456789abcdef, .is_secured = true, .uses_topic = true, .count = 13};
  EXPECT_EQ(to_text(data), this_release + "3st/0123456789abcdef") << "the count has one digit";
}

TEST(ParticipantDataTest, OfOtherProgramsAndReleasesAreNone) {
  for (const std::string text :
       {"", "x", "sft", "sft/", "sft/1/3/0123456789abcdef", "SFT/15/3/0123456789abcdef"})
    EXPECT_FALSE(parse_participant_data(text)) << text;
}

TEST(ParticipantDataTest, ThatAreMalformedAreNone) {
  for (const std::string tail :
       {"", "3", "3/", "/0123456789abcdef", "3/0123456789abcde", "3/0123456789abcdefa", "3/0000000000000000",
        "3/0123456789abcdeg", "x/0123456789abcdef", "3/-123456789abcdef"})
    EXPECT_FALSE(parse_participant_data(this_release + tail)) << tail;
}

TEST(ParticipantDataTest, NameTheOtherRelease) {
  EXPECT_THAT(other_release("sft/3/1"), Optional(3u));
  EXPECT_THAT(other_release("sft/9999/anything at all"), Optional(9999u));
  for (const std::string& text :
       {this_release + "3/0", std::string("sft/"), std::string("sft//1"), std::string("sft/07/1"),
        std::string("sft/12345/1"), std::string("sft/1x/1"), std::string("other/3/1")})
    EXPECT_FALSE(other_release(text)) << text;
}

}  // namespace
}  // namespace sft::core
