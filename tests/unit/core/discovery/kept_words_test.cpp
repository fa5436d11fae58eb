// What is in force of what was said is kept for those who listen later.
#include "core/discovery/kept_words.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

namespace sft::core {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr Participants::Guid anna{1}, bob{2};

Endpoint endpoint(EndpointId id, std::uint64_t revision = 1) {
  Endpoint announced;
  announced.id = id;
  announced.revision = revision;
  return announced;
}

Request request(EndpointId reader, std::uint64_t sequence) {
  Request asked;
  asked.reader = reader;
  asked.sequence = sequence;
  return asked;
}

template <class What>
void say(KeptWords& words, const Participants::Guid& speaker, What what) {
  words.learn(std::make_shared<const ControlWord>(ControlWord{speaker, std::move(what)}));
}

std::vector<std::string> kept(const KeptWords& words) {
  std::vector<std::string> texts;
  for (const KeptWords::Word& word : words.all()) {
    const std::string speaker = *word->speaker == anna ? "anna: " : "bob: ";
    if (const auto* const announced = std::get_if<Endpoint>(&word->what)) {
      texts.push_back(speaker + "endpoint " + std::to_string(announced->id) + " revision " +
                      std::to_string(announced->revision));
    } else if (const auto* const asked = std::get_if<Request>(&word->what)) {
      texts.push_back(speaker + "request " + std::to_string(asked->sequence) + " of " +
                      std::to_string(asked->reader));
    }
  }
  return texts;
}

TEST(KeptWords, AreTheLatestOfEachParticipantWithAnnouncementsFirst) {
  KeptWords words;
  say(words, anna, request(5, 1));
  say(words, anna, endpoint(5, 1));
  say(words, anna, endpoint(5, 2));
  say(words, anna, request(5, 2));
  say(words, bob, endpoint(5, 1));
  EXPECT_THAT(kept(words), ElementsAre("anna: endpoint 5 revision 2", "bob: endpoint 5 revision 1",
                                       "anna: request 2 of 5"));
}

TEST(KeptWords, EndWithTheirEndpointWhichOnlyItsOwnParticipantWithdraws) {
  KeptWords words;
  say(words, anna, endpoint(5));
  say(words, anna, request(5, 1));
  say(words, bob, EndpointWithdrawn{5});
  EXPECT_THAT(kept(words), ElementsAre("anna: endpoint 5 revision 1", "anna: request 1 of 5"));
  say(words, anna, EndpointWithdrawn{5});
  EXPECT_THAT(kept(words), IsEmpty());
}

TEST(KeptWords, OfAllEndWhenNobodyKeepsTheEndpointAlive) {
  KeptWords words;
  say(words, anna, endpoint(5));
  say(words, bob, endpoint(5));
  say(words, bob, request(5, 1));
  say(words, bob, endpoint(6));
  words.learn(std::make_shared<const ControlWord>(ControlWord{std::nullopt, EndpointUnheard{5}}));
  EXPECT_THAT(kept(words), ElementsAre("bob: endpoint 6 revision 1"));
}

TEST(KeptWords, OfAParticipantThatDepartedAreForgotten) {
  KeptWords words;
  say(words, anna, endpoint(5));
  say(words, bob, endpoint(6));
  say(words, anna, request(7, 1));
  words.forget(anna);
  EXPECT_THAT(kept(words), ElementsAre("bob: endpoint 6 revision 1"));
}

TEST(KeptWords, AreNotWhatOnlyLivesForAMoment) {
  KeptWords words;
  say(words, anna, SignOfLife{});
  say(words, anna, SampleMalformed{"no version"});
  say(words, anna, EndpointMet{});
  EXPECT_THAT(kept(words), IsEmpty());
}

TEST(KeptWords, CountTheRequestWithinAnAnnouncement) {
  KeptWords words(100'000);
  Endpoint fat = endpoint(1);
  fat.request.listening.assign(writers_per_reader_max, 1);
  fat.request.attached.assign(writers_per_reader_max, 1);
  for (fat.id = 1; fat.id < 10; ++fat.id) say(words, anna, fat);
  EXPECT_FALSE(words.are_complete());
}

// Somebody who announces without end takes no more memory than that.
TEST(KeptWords, SayThatTheyAreNotCompleteRatherThanGrowWithoutBound) {
  constexpr std::size_t bytes_max = 100'000;
  KeptWords words(bytes_max);
  for (EndpointId id = 1; words.are_complete(); ++id) {
    ASSERT_LT(id, bytes_max);
    say(words, anna, endpoint(id));
  }
  EXPECT_THAT(kept(words), IsEmpty());
  say(words, anna, endpoint(1));
  EXPECT_THAT(kept(words), IsEmpty()) << "what came before would be missing";
  words.clear();
  say(words, anna, endpoint(1));
  EXPECT_THAT(kept(words), ElementsAre("anna: endpoint 1 revision 1"));
}

}  // namespace
}  // namespace sft::core
