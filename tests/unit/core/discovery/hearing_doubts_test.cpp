// Frequent signs of life are wanted where they help to find out what is missing, and nowhere else.
#include <gtest/gtest.h>

#include "core/discovery/life_signs.h"
#include "tests/unit/core/discovery/hearing_watch_fixture.h"

namespace sft::core {
namespace {

using namespace test;
using Missing = HearingWatch::Missing;

class HearingDoubts : public HearingWatchTest {};

TEST_F(HearingDoubts, FindsASignLateUntilItsLeaseEnds) {
  passes(2s);
  EXPECT_FALSE(watch.is_a_sign_late(now));
  now += life_signs_to_all.pause_in_calm + 400ms;
  look();
  EXPECT_FALSE(watch.is_a_sign_late(now)) << "seldom signs are not late";
  now += 101ms;
  EXPECT_TRUE(watch.is_a_sign_late(now));
  watch.heard_life(its_peer, heard_node, all_said, its_lease, now);
  EXPECT_FALSE(watch.is_a_sign_late(now));
  now += 2s;
  EXPECT_TRUE(watch.is_a_sign_late(now));
  watch.life_ended(lan, heard_node);
  EXPECT_FALSE(watch.is_a_sign_late(now)) << "the dead give none";
}

TEST_F(HearingDoubts, MayMissSomethingWhileSignsTellSomethingElseThanIsKnown) {
  passes(2s);
  passes(500ms, all_said + 7);
  EXPECT_TRUE(watch.may_miss_something()) << "somebody says more than is known";
  known[its_peer] = all_said + 7;
  look();
  EXPECT_FALSE(watch.may_miss_something());
}

/// Announcements of 64 nodes that begin at once overtake their signs of life by more than those of one.
TEST_F(HearingDoubts, InACrowdCountOnceTheyHaveLasted) {
  constexpr AnnouncerId others = 62;
  for (AnnouncerId i = 0; i < others; ++i) comes({lan, 100 + i}, 1000 + i);
  passes(2s);
  passes(1s, all_said + 7);
  EXPECT_FALSE(watch.may_miss_something());
  passes(1s, all_said + 7);
  EXPECT_TRUE(watch.may_miss_something());
  known[its_peer] = all_said + 7;
  look();
  EXPECT_FALSE(watch.may_miss_something());
  passes(500ms, all_said + 9);
  EXPECT_FALSE(watch.may_miss_something()) << "the former doubt is over";
}

TEST_F(HearingDoubts, OfANewcomerInACrowdHaveToLastLonger) {
  constexpr AnnouncerId others = 62;
  for (AnnouncerId i = 0; i < others; ++i) comes({lan, 100 + i}, 1000 + i);
  passes(3s, all_said + 7);
  EXPECT_FALSE(watch.may_miss_something()) << "it is still told what all have announced";
  passes(2s, all_said + 7);
  EXPECT_TRUE(watch.may_miss_something());
}

TEST_F(HearingDoubts, AreLookedAtOftenUntilTheyCount) {
  comes(other_peer, heard_node + 1);
  passes(2s);
  passes(500ms, all_said + 7);
  EXPECT_FALSE(watch.may_miss_something());
  const Time next = watch.next_look_in_doubt();
  EXPECT_LE(next, now + 100ms);
  now = next;
  look();
  EXPECT_TRUE(watch.may_miss_something());
}

TEST_F(HearingDoubts, LetsTheNextSignConfirmWhatCameAfterTheLastOne) {
  passes(2s);
  known[its_peer] = all_said + 7;
  watch.heard(its_peer, now += 60ms);
  look();
  EXPECT_FALSE(watch.may_miss_something()) << "a request has come, as after each change of a mask";
  passes(500ms, all_said + 7);
  EXPECT_FALSE(watch.may_miss_something());
}

TEST_F(HearingDoubts, ComparesASignWithWhatIsKnownAtTheNextLook) {
  passes(2s);
  known[its_peer] = all_said + 7;
  watch.heard(its_peer, now += 60ms);
  watch.heard_life(its_peer, heard_node, all_said + 7, its_lease, now += 90ms);
  EXPECT_FALSE(watch.may_miss_something()) << "in a crowd looks are rarer than signs";
  now += 50ms;
  look();
  EXPECT_FALSE(watch.may_miss_something());
}

TEST_F(HearingDoubts, MayMissSomethingIfTheNextSignDoesNotConfirmWhatCame) {
  passes(2s);
  known[its_peer] = all_said + 7;
  watch.heard(its_peer, now);
  look();
  passes(500ms);
  EXPECT_TRUE(watch.may_miss_something()) << "somebody else may have said it";
}

TEST_F(HearingDoubts, MayMissSomethingWhileNothingComesOfAParticipant) {
  passes(2s);
  now += participant_lease * 2;
  look();
  EXPECT_EQ(deaf, Missing::everything);
  EXPECT_TRUE(watch.may_miss_something());
}

TEST_F(HearingDoubts, MissesNothingOfAParticipantForWhichNothingHelps) {
  for (int i = 0; i < 3; ++i) watch.tried(its_peer.participant);
  passes(60s, all_said + 7);
  EXPECT_FALSE(watch.may_miss_something()) << "or all nodes would give frequent signs for ever";
}

}  // namespace
}  // namespace sft::core
