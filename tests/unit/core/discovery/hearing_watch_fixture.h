// A watch with one peer that it hears, and time that a test lets pass.
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "core/discovery/hearing_watch.h"

namespace sft::core::test {

using namespace std::chrono_literals;

inline constexpr LinkId lan = 1;
inline constexpr NodeId heard_node = 77;
inline constexpr Speaker its_peer{lan, 11}, other_peer{lan, 12};
inline constexpr std::uint32_t all_said = 1234;
inline constexpr auto its_lease = 5000ms, participant_lease = 20'000ms;

class HearingWatchTest : public ::testing::Test {
 protected:
  HearingWatchTest() {
    watch.link_made(lan);
    watch.participant_came(its_peer, now);
    watch.participant_speaks(its_peer, now);
  }

  /// Time passes in which the peer says that it lives, and what it has announced; nothing if that is 0.
  void passes(std::chrono::milliseconds duration, std::uint32_t said = all_said) {
    for (const auto end = now + duration; now < end;) {
      now += 500ms;
      if (said != 0) watch.heard_life(its_peer, heard_node, said, its_lease, now);
      look();
    }
  }
  void look() {
    deaf.reset();
    remedies.clear();
    for (const auto& one : watch.look(known, participant_lease, now)) {
      deaf = one.missing;
      remedies.push_back(one.remedy);
    }
  }
  /// A participant of the node comes, and says that the node lives.
  void comes(Speaker speaker, NodeId of = heard_node) {
    watch.participant_came(speaker, now);
    watch.participant_speaks(speaker, now);
    known[speaker] = all_said;
    watch.heard_life(speaker, of, all_said, its_lease, now);
  }
  /// Somebody else has said something in the peer's name, which says itself what it said before.
  void is_forged() {
    known[its_peer] = all_said + 7;
    now += 50ms;
    look();
    now += 150ms;
    watch.heard_life(its_peer, heard_node, all_said, its_lease, now);
    look();
  }

  HearingWatch watch;
  Time now{1000s};
  std::map<Speaker, std::uint32_t> known{{its_peer, all_said}};
  std::optional<HearingWatch::Missing> deaf;
  std::vector<HearingWatch::Remedy> remedies;
};

}  // namespace sft::core::test
