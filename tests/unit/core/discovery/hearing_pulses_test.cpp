// Pulses count as signs of life of a speaker whose full signs have been heard, and show whether these come.
#include <gtest/gtest.h>

#include "core/discovery/life_signs.h"
#include "core/node/tick_pace.h"
#include "tests/unit/core/discovery/hearing_watch_fixture.h"

namespace sft::core {
namespace {

using namespace test;
using Missing = HearingWatch::Missing;

class HearingPulses : public HearingWatchTest {
 protected:
  bool full_sign_comes(std::uint32_t said = all_said) {
    ++full_signs;
    watch.heard_life(its_peer, heard_node, said, full_sign_lease, now);
    return true;
  }
  bool pulse_comes(std::uint32_t said = all_said) {
    return watch.heard_pulse(its_peer, {.node = heard_node, .full_signs = full_signs}, said, last_look, now);
  }
  void is_announced() { watch.heard(its_peer, now, heard_node); }
  void looks() {
    look();
    last_look = now;
  }
  /// Pulses come, and nothing else.
  void pulses_come_for(std::chrono::milliseconds duration, std::uint32_t said = all_said) {
    for (const auto end = now + duration; now < end;) {
      now += 466ms;
      pulse_comes(said);
      looks();
    }
  }
  /// And nobody else's.
  void expect_that_its_pulses_count_until_its_end() {
    EXPECT_TRUE(pulse_comes());
    EXPECT_FALSE(watch.heard_pulse(its_peer, {.node = heard_node + 1}, all_said, now, now)) << "another node";
    EXPECT_FALSE(watch.heard_pulse(other_peer, {.node = heard_node}, all_said, now, now))
        << "another speaker";
    watch.life_ended(lan, heard_node);
    EXPECT_FALSE(pulse_comes()) << "Cyclone has told of its end";
  }
  void expect_that_full_signs_are_wanted_after_a_while() {
    pulses_come_for(2s);
    EXPECT_FALSE(watch.may_miss_something()) << "full signs for newcomers are yet to come";
    pulses_come_for(1s);
    EXPECT_TRUE(watch.may_miss_something());
    full_sign_comes();
    pulses_come_for(1s);
    EXPECT_FALSE(watch.may_miss_something());
  }
  void expect_that_first_full_signs_are_missed() {
    for (int lost = 0; lost < 4; ++lost, ++full_signs) {
      pulses_come_for(932ms);
      EXPECT_FALSE(deaf) << "so many may get lost";
    }
    pulses_come_for(1s);
    EXPECT_EQ(deaf, Missing::signs_of_life);
  }

  std::uint8_t full_signs = 0;
  Time last_look = now;
};

TEST_F(HearingPulses, CountOnceTheSpeakerHasAnnouncedAnEndpointOfTheNode) {
  EXPECT_FALSE(pulse_comes());
  is_announced();
  expect_that_its_pulses_count_until_its_end();
}

TEST_F(HearingPulses, OfAnAnnouncedNodeAreNotLateAndTellOfAnnouncementsThatAreMissing) {
  is_announced();
  pulses_come_for(1s);
  EXPECT_FALSE(watch.is_a_sign_late(now));
  EXPECT_FALSE(watch.may_miss_something());
  pulses_come_for(1s, all_said + 7);
  EXPECT_TRUE(watch.may_miss_something());
  now += 3s;
  EXPECT_TRUE(watch.is_a_sign_late(now));
}

TEST_F(HearingPulses, OfAnAnnouncedNodeAskForFullSignsAfterAWhile) {
  is_announced();
  expect_that_full_signs_are_wanted_after_a_while();
}

TEST_F(HearingPulses, AskForNoFullSignsWhereThoseDoNotArriveYet) {
  constexpr LinkId new_link = 5;
  constexpr Speaker there{new_link, 11};
  watch.link_made(new_link, false);
  watch.participant_speaks(there, now);
  watch.heard(there, now, heard_node);
  known[there] = all_said;
  const auto pulses_come_there_for = [&](std::chrono::milliseconds duration) {
    for (const auto end = now + duration; now < end;) {
      now += 466ms;
      watch.heard_life(its_peer, heard_node, all_said, its_lease, now);
      EXPECT_TRUE(watch.heard_pulse(there, {.node = heard_node, .full_signs = ++full_signs}, all_said,
                                    last_look, now));
      looks();
    }
  };
  pulses_come_there_for(10s);
  EXPECT_FALSE(watch.may_miss_something());
  EXPECT_FALSE(deaf);
  watch.link_made(new_link);
  pulses_come_there_for(1s);
  EXPECT_FALSE(watch.may_miss_something()) << "they are yet to come";
  pulses_come_there_for(10s);
  EXPECT_EQ(deaf, Missing::signs_of_life);
}

TEST_F(HearingPulses, DoNotCountBeforeAFullSignOfTheSpeakerHasNamedTheNode) {
  EXPECT_FALSE(pulse_comes());
  full_sign_comes();
  expect_that_its_pulses_count_until_its_end();
}

TEST_F(HearingPulses, CountThoughSomebodyElseHasNamedAnotherNodeInTheNameOfTheSpeaker) {
  known[its_peer] = all_said + 7;
  look();
  full_sign_comes();
  watch.heard_life(its_peer, 1, 0, full_sign_lease, now);
  EXPECT_TRUE(pulse_comes());
}

TEST_F(HearingPulses, KeepSeldomFullSignsFromBeingMissed) {
  full_sign_comes();
  pulses_come_for(full_sign_pause);
  EXPECT_FALSE(watch.is_a_sign_late(now));
  EXPECT_FALSE(watch.may_miss_something());
  EXPECT_FALSE(deaf);
}

TEST_F(HearingPulses, InCalmAreNotLateHoweverLooksAndPulsesMeet) {
  constexpr auto pulse_pause = life_signs_by_pulses.pause_in_calm;
  for (auto look_pause = TickPace::pause_in_calm - 3ms; look_pause < TickPace::pause_in_calm + 20ms;
       look_pause += 1ms) {
    full_sign_comes();
    pulse_comes();
    looks();
    Time next_pulse = now + pulse_pause;
    for (int i = 0; i < 1000; ++i) {
      now += look_pause;
      for (; next_pulse <= now; next_pulse += pulse_pause) pulse_comes();
      if (i % 10 == 0) full_sign_comes();
      ASSERT_FALSE(watch.is_a_sign_late(now)) << look_pause.count() << " ms, look " << i;
      looks();
    }
  }
}

TEST_F(HearingPulses, InCalmAreLateAfterTwoLooksWithoutAny) {
  full_sign_comes();
  pulse_comes();
  looks();
  now += TickPace::pause_in_calm;
  EXPECT_FALSE(watch.is_a_sign_late(now));
  looks();
  now += TickPace::pause_in_calm;
  EXPECT_TRUE(watch.is_a_sign_late(now));
}

TEST_F(HearingPulses, AreLateThoughFullSignsCome) {
  for (int i = 0; i < 3; ++i) {
    full_sign_comes();
    EXPECT_FALSE(watch.is_a_sign_late(now));
    now += 600ms;
  }
  full_sign_comes();
  now += 100ms;
  EXPECT_TRUE(watch.is_a_sign_late(now)) << "a firewall may drop pulses: full signs have to be frequent";
  pulse_comes();
  EXPECT_FALSE(watch.is_a_sign_late(now));
}

TEST_F(HearingPulses, AreNotExpectedOfASpeakerWhoseLeaseSaysThatItGivesNone) {
  passes(10s);
  EXPECT_FALSE(watch.is_a_sign_late(now));
}

TEST_F(HearingPulses, TellOfAnnouncementsThatAreMissing) {
  full_sign_comes();
  pulses_come_for(2s);
  pulses_come_for(1s, all_said + 7);
  EXPECT_TRUE(watch.may_miss_something());
  pulses_come_for(2s, all_said + 7);
  EXPECT_EQ(deaf, Missing::announcements);
}

TEST_F(HearingPulses, ThatHaveWaitedDoNotTakeBackWhatAFullSignHasSaidMeanwhile) {
  full_sign_comes();
  pulses_come_for(2s);
  now += 300ms;
  known[its_peer] = all_said + 7;
  full_sign_comes(all_said + 7);
  now += 166ms;
  EXPECT_TRUE(pulse_comes(all_said)) << "it came before the full sign";
  looks();
  now += 466ms;
  looks();
  EXPECT_FALSE(watch.may_miss_something());
}

TEST_F(HearingPulses, ContradictWhatSomebodyElseHasSaid) {
  full_sign_comes();
  pulses_come_for(3s);
  known[its_peer] = all_said + 7;
  pulses_come_for(1s);
  EXPECT_EQ(deaf, Missing::announcements);
}

TEST_F(HearingPulses, AskForFrequentSignsWhenAFullOneIsMissing) {
  full_sign_comes();
  pulses_come_for(1s);
  ++full_signs;  // it gets lost
  pulses_come_for(466ms);
  EXPECT_TRUE(watch.may_miss_something());
  EXPECT_FALSE(deaf);
  full_sign_comes();
  pulses_come_for(1s);
  EXPECT_FALSE(watch.may_miss_something());
}

TEST_F(HearingPulses, OfANodeThatNoFullSignHasNamedAskForFrequentOnesAfterAWhile) {
  expect_that_full_signs_are_wanted_after_a_while();
}

TEST_F(HearingPulses, ShowThatCycloneHasDiscardedTheFirstFullSignsOfAnAnnouncedNode) {
  is_announced();
  expect_that_first_full_signs_are_missed();
}

TEST_F(HearingPulses, ShowThatCycloneHasDiscardedTheFirstFullSigns) {
  expect_that_first_full_signs_are_missed();
  full_sign_comes();
  looks();
  EXPECT_FALSE(deaf);
}

TEST_F(HearingPulses, ShowThatASignOfSomebodyElseHasMadeTheFirstFullSignsOld) {
  constexpr NodeId made_up = 1;
  watch.heard_life(its_peer, made_up, all_said, full_sign_lease, now);
  expect_that_first_full_signs_are_missed();
}

TEST_F(HearingPulses, OfASpeakerThatGivesNoFullSignsShowNothing) {
  pulses_come_for(7s);
  EXPECT_FALSE(deaf);
}

TEST_F(HearingPulses, ThatCameAfterTheEndOfTheirNodeAskForNothing) {
  full_sign_comes();
  pulses_come_for(1s);
  watch.life_ended(lan, heard_node);
  for (int i = 0; i < 5; ++i) {
    pulse_comes();
    for (const auto end = now + 3s; now < end; now += 466ms) {
      looks();
      EXPECT_FALSE(watch.may_miss_something());
    }
  }
}

TEST_F(HearingPulses, OfAFullSignThatIsStillOnItsWayAskForNothing) {
  full_sign_comes();
  pulses_come_for(1s);
  // The speaker counts a full sign after the pulse that goes with it.
  pulse_comes();
  looks();
  EXPECT_FALSE(watch.may_miss_something());
  full_sign_comes();
  pulses_come_for(1s);
  EXPECT_FALSE(watch.may_miss_something());
}

TEST_F(HearingPulses, ShowThatCycloneDiscardsFullSigns) {
  full_signs = 250;  // their number begins again with 0 meanwhile
  full_sign_comes();
  pulses_come_for(1s);
  for (int lost = 0; lost < 7; ++lost) {
    ++full_signs;
    pulses_come_for(466ms);
    EXPECT_FALSE(deaf) << "so many may get lost";
  }
  full_signs += 1;
  pulses_come_for(1s);
  EXPECT_FALSE(deaf) << "one pulse may be somebody else's";
  pulses_come_for(1s);
  EXPECT_EQ(deaf, Missing::signs_of_life);
  full_sign_comes();
  pulses_come_for(1s);
  EXPECT_FALSE(deaf);
}

TEST_F(HearingPulses, ThatSomebodyElseHasSentAreCorrectedByTheNextOne) {
  full_sign_comes();
  pulses_come_for(1s);
  for (int i = 0; i < 20; ++i) {
    watch.heard_pulse(its_peer, {.node = heard_node, .full_signs = 100}, all_said, last_look, now);
    looks();
    pulses_come_for(932ms);
    EXPECT_FALSE(deaf) << i;
  }
}

TEST_F(HearingPulses, DoNotEndTheWatchOverFullSigns) {
  full_sign_comes();
  pulses_come_for(full_sign_lease);
  EXPECT_FALSE(deaf);
  pulses_come_for(1s);
  EXPECT_EQ(deaf, Missing::signs_of_life) << "Cyclone says that they come";
}

}  // namespace
}  // namespace sft::core
