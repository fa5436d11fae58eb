// Decides whether this process gives signs of life often, or seldom because all is calm. Pure.
//
// Signs are to be frequent where one of them matters: while somebody may be missing or may have spoken in
// somebody's name, where a node is heard by several ways, of which the silent one has to be found, and for a
// while after each change. Any node can want that of everybody: it says so in its own signs. So where
// datagrams get lost, all give signs as often as the lease needs, and elsewhere half as many will do.
#pragma once

#include <algorithm>
#include <chrono>

#include "core/platform/clock.h"

namespace sft::core {

class SignPace {
 public:
  /// Long enough for datagrams that get lost to show again, also where there are only two nodes.
  static constexpr std::chrono::seconds wish_lasts{30};
  static constexpr std::chrono::seconds news_last{3};

  /// A node of this process has announced, withdrawn or asked for something: others compare that with its
  /// signs.
  void told_news(Time now) { news_until_ = now + news_last; }
  /// Another process wants frequent signs of everybody.
  void others_want(Time now) { wish_until_ = now + wish_lasts; }
  /// This process wants frequent signs of everybody, or does not any more.
  void want(bool wants, Time now) {
    wants_ = wants;
    if (wants) wish_until_ = now + wish_lasts;
  }

  bool wants() const { return wants_; }
  Time calm_from() const { return std::max(wish_until_, news_until_); }
  bool is_calm(Time now) const { return now >= calm_from(); }

 private:
  bool wants_ = false;
  Time wish_until_{};
  Time news_until_{};
};

}  // namespace sft::core
