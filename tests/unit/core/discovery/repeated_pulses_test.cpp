// Pulses that say what was said before wait, and nobody can tell.
#include "core/discovery/repeated_pulses.h"

#include <gtest/gtest.h>

#include <array>
#include <utility>
#include <variant>
#include <vector>

#include "core/discovery/leases.h"
#include "core/discovery/life_signs.h"

namespace sft::core {
namespace {

using std::chrono::milliseconds;
using namespace std::chrono_literals;

constexpr Speaker first_speaker{1, 11}, second_speaker{1, 12};
constexpr NodeId first_node = 7, second_node = 8;

class RepeatedPulsesTest : public ::testing::Test {
 protected:
  RepeatedPulsesTest() {
    hearing.link_made(1);
    const std::array others{std::pair(first_speaker, first_node), std::pair(second_speaker, second_node)};
    for (const auto& [speaker, node] : others) {
      hearing.participant_speaks(speaker, now);
      hearing.heard_life(speaker, node, 0, full_sign_lease, now);
      merge.assertion_came(speaker, {.node = node, .writers = {}}, now);
      is_told(speaker, node);
    }
    (void)merge.take_news();
    looks();
  }

  static Pulse pulse(const Speaker& speaker, NodeId node) {
    return {.node = node, .participant = static_cast<std::uint32_t>(speaker.participant + 1000)};
  }
  void is_told(const Speaker& speaker, NodeId node) {
    const Pulse told = pulse(speaker, node);
    EXPECT_TRUE(hearing.heard_pulse(speaker, told, 0, now - 1s, now));
    merge.pulse_came(speaker, node, now);
    pulses.told({.speaker = speaker, .pulse = told, .digest = 0}, now - 1s, now);
  }
  bool waits(const Pulse& pulse) { return pulses.waits(1, pulse, now - 1s, now); }
  void looks() {
    merge.pulses_heard(now);
    (void)hearing.look(merge.digests(), 20s, now);
    merge.tick(now);
    pulses.looked(now);
  }
  /// The nodes that a look finds lost.
  std::vector<NodeId> lost() {
    looks();
    std::vector<NodeId> nodes;
    for (const News& news : merge.take_news()) {
      if (const auto* const lost = std::get_if<NodeLost>(&news)) nodes.push_back(lost->id);
    }
    return nodes;
  }

  Time now{1000s};
  HearingWatch hearing;
  LinkMerge merge;
  RepeatedPulses pulses;
};

TEST_F(RepeatedPulsesTest, WaitOnceAllIsSteady) {
  EXPECT_FALSE(waits(pulse(first_speaker, first_node)));
  pulses.begin(2, 2, now);
  EXPECT_TRUE(waits(pulse(first_speaker, first_node)));
  EXPECT_FALSE(waits(pulse(first_speaker, first_node + 100))) << "nobody has said that before";
  EXPECT_FALSE(pulses.waits(2, pulse(first_speaker, first_node), now, now)) << "it comes by another link";
}

TEST_F(RepeatedPulsesTest, DoNotWaitUnlessEverybodyWhoLivesIsHeard) {
  pulses.begin(3, 2, now);
  EXPECT_FALSE(waits(pulse(first_speaker, first_node))) << "a node lives whose pulses do not come";
  pulses.begin(2, 3, now);
  EXPECT_FALSE(waits(pulse(first_speaker, first_node))) << "somebody is there who says nothing";
  now += silence_in(lease_default) + 1ms;
  is_told(first_speaker, first_node);
  pulses.begin(2, 2, now);
  EXPECT_FALSE(waits(pulse(first_speaker, first_node))) << "the other one has fallen silent";
}

TEST_F(RepeatedPulsesTest, TellSomethingIfTheirDigestIsAnotherOne) {
  pulses.begin(2, 2, now);
  Pulse changed = pulse(first_speaker, first_node);
  changed.digest_of_writers = 1;
  EXPECT_FALSE(waits(changed));
  EXPECT_FALSE(pulses.is_as_before(1, changed));
  changed = pulse(first_speaker, first_node);
  changed.digest_of_readers = 1;
  EXPECT_FALSE(waits(changed));
  EXPECT_FALSE(pulses.is_as_before(1, changed));
}

TEST_F(RepeatedPulsesTest, TellOfAFullSignThatDidNotCome) {
  pulses.begin(2, 2, now);
  Pulse after = pulse(first_speaker, first_node);
  after.full_signs = 1;
  EXPECT_FALSE(waits(after));
  EXPECT_TRUE(pulses.is_as_before(1, after)) << "nothing else has changed";
}

TEST_F(RepeatedPulsesTest, TellNothingOfAFullSignThatCame) {
  pulses.begin(2, 2, now);
  EXPECT_TRUE(pulses.full_sign_is_as_before(first_speaker, first_node, 0));
  Pulse after = pulse(first_speaker, first_node);
  after.full_signs = 1;
  EXPECT_TRUE(waits(after));
  EXPECT_TRUE(waits(after)) << "it is the last one from now on";
  after.full_signs = 2;
  EXPECT_FALSE(waits(after)) << "only one has come";
}

TEST_F(RepeatedPulsesTest, AreNotWhatAFullSignSaysOtherwise) {
  EXPECT_FALSE(pulses.full_sign_is_as_before(first_speaker, first_node, 0)) << "it is not steady";
  pulses.begin(2, 2, now);
  EXPECT_FALSE(pulses.full_sign_is_as_before(first_speaker, first_node, 1)) << "another digest";
  EXPECT_FALSE(pulses.full_sign_is_as_before(second_speaker, first_node, 0)) << "another speaker";
  EXPECT_FALSE(pulses.full_sign_is_as_before(first_speaker, first_node + 100, 0)) << "another node";
}

// Pulses wait at the socket for a look, while full signs are heard as they come.
TEST_F(RepeatedPulsesTest, MayHaveBeenSentBeforeAFullSignThatCame) {
  pulses.begin(2, 2, now);
  EXPECT_TRUE(pulses.full_sign_is_as_before(first_speaker, first_node, 0));
  Pulse next = pulse(first_speaker, first_node);
  EXPECT_TRUE(waits(next)) << "it does not tell of the full sign yet";
  next.full_signs = 1;
  EXPECT_TRUE(waits(next)) << "the full sign came before";
  next.full_signs = 2;
  EXPECT_FALSE(waits(next)) << "only one has come";
}

TEST_F(RepeatedPulsesTest, NeedALookIfSomebodyIsSilent) {
  EXPECT_FALSE(pulses.need_no_look(now));
  pulses.begin(2, 2, now);
  EXPECT_TRUE(pulses.need_no_look(now));
  now += silence_in(lease_default);
  EXPECT_TRUE(pulses.need_no_look(now));
  now += 1ms;
  EXPECT_TRUE(waits(pulse(first_speaker, first_node)));
  EXPECT_FALSE(pulses.need_no_look(now)) << "the other one";
  EXPECT_TRUE(waits(pulse(second_speaker, second_node)));
  EXPECT_TRUE(pulses.need_no_look(now));
}

TEST_F(RepeatedPulsesTest, DoNotWaitForEver) {
  pulses.begin(2, 2, now);
  const Time begin = now;
  for (; now - begin < RepeatedPulses::waits_max; now += 1s) {
    EXPECT_TRUE(pulses.need_no_look(now));
    EXPECT_TRUE(waits(pulse(first_speaker, first_node)) && waits(pulse(second_speaker, second_node)));
  }
  EXPECT_FALSE(pulses.need_no_look(now));
  looks();
  EXPECT_TRUE(pulses.need_no_look(now));
}

TEST_F(RepeatedPulsesTest, CountAsOfTheTimeWhenTheyCame) {
  pulses.begin(2, 2, now);
  for (int second = 0; second < 9; ++second) {
    now += 1s;
    EXPECT_TRUE(waits(pulse(first_speaker, first_node)) && waits(pulse(second_speaker, second_node)));
  }
  const Time last = now;
  now += 1s;
  pulses.tell(hearing, merge);
  EXPECT_FALSE(hearing.is_a_sign_late(now));
  now = last + lease_default;
  EXPECT_EQ(lost(), std::vector<NodeId>{});
  now += 1ms;
  EXPECT_EQ(lost(), (std::vector<NodeId>{first_node, second_node}));
}

TEST_F(RepeatedPulsesTest, OfOneNodeAreToldAlone) {
  pulses.begin(2, 2, now);
  const Time begin = now;
  now += 3s;
  EXPECT_TRUE(waits(pulse(first_speaker, first_node)) && waits(pulse(second_speaker, second_node)));
  pulses.make_way(first_node, true, hearing, merge);
  now = begin + lease_default + 1ms;
  EXPECT_EQ(lost(), std::vector<NodeId>{second_node}) << "that was not told";
}

TEST_F(RepeatedPulsesTest, AreNotNotedWithoutEnd) {
  std::size_t told = 2;
  for (; told < RepeatedPulses::voices_max + 1; ++told)
    pulses.told({.speaker = first_speaker, .pulse = pulse(first_speaker, 1000 + told)}, now, now);
  pulses.begin(told, 2, now);
  EXPECT_FALSE(waits(pulse(first_speaker, first_node))) << "one is not known";
  pulses.begin(told - 1, 2, now);
  EXPECT_TRUE(waits(pulse(first_speaker, first_node)));
}

TEST_F(RepeatedPulsesTest, AreAllToldAndForgottenInTheEnd) {
  pulses.begin(2, 2, now);
  now += 3s;
  EXPECT_TRUE(waits(pulse(first_speaker, first_node)) && waits(pulse(second_speaker, second_node)));
  pulses.end(hearing, merge);
  EXPECT_FALSE(hearing.is_a_sign_late(now));
  EXPECT_FALSE(waits(pulse(first_speaker, first_node)));
  pulses.begin(2, 2, now);
  EXPECT_FALSE(waits(pulse(first_speaker, first_node))) << "each has to be told once more";
}

}  // namespace
}  // namespace sft::core
