// Decides whether this process gives signs of life often, or seldom because all is calm. Pure.
//
// Signs are to be frequent where one of them matters: while somebody may be missing or may have spoken in
// somebody's name, where a node is heard by several ways, of which the silent one has to be found, and for a
// while after each change. Any node can want that of everybody: it says so in its own signs. So where
// datagrams get lost, all give signs as often as the lease needs, and elsewhere half as many will do.
#pragma once

#include <algorithm>
#include <chrono>

#include "core/discovery/life_signs.h"
#include "core/platform/clock.h"

namespace sft::core {

class SignPace {
 public:
  /// `signs`: of this process, and of those who want something.
  explicit SignPace(const LifeSigns& signs = life_signs_to_all) : repeated_for_(4 * signs.pause + slack) {}

  static constexpr std::chrono::seconds news_last{3};
  /// Late signs tell of a network that loses datagrams. It will lose more, which has to show again, also
  /// where there are only two nodes.
  static constexpr std::chrono::seconds after_late_sign{30};

  /// A node of this process has announced, withdrawn or asked for something: others compare that with its
  /// signs.
  void told_news(Time now) { news_until_ = now + news_last; }
  /// Another process wants frequent signs of everybody. It repeats that with each of its own, of which three
  /// may get lost.
  void others_want(Time now) { heard_wish_until_ = now + repeated_for_; }

  // This process wants frequent signs of everybody.

  /// Something may be missing: what is wanted comes soon, or is missed for longer and wanted again.
  void want_after_doubt(Time now) { want_until(now + repeated_for_); }
  void want_after_late_sign(Time now) { want_until(now + after_late_sign); }

  bool wants(Time now) const { return now < wants_until_; }
  /// Somebody wants them: this process or another.
  bool are_wanted(Time now) const { return wants(now) || now < heard_wish_until_; }
  Time calm_from() const { return std::max({wants_until_, heard_wish_until_, news_until_}); }
  bool is_calm(Time now) const { return now >= calm_from(); }
  /// The time for which a wish lasts that is not repeated.
  std::chrono::milliseconds repeated_for() const { return repeated_for_; }

 private:
  static constexpr std::chrono::milliseconds slack{400};  // signs are given at the next tick

  void want_until(Time end) { wants_until_ = std::max(wants_until_, end); }

  std::chrono::milliseconds repeated_for_;
  Time wants_until_{};
  Time heard_wish_until_{};
  Time news_until_{};
};

}  // namespace sft::core
