// Gives turns where many have something to say again and again, and not all of them fit in at once. Pure.
#pragma once

#include <cstddef>
#include <optional>
#include <utility>

namespace sft::core {

/// `Key` sorts those who take turns.
template <class Key>
class Turns {
 public:
  /// Offers a turn to each of `all`, a set of keys or a map of them, beginning behind the one that took the
  /// last turn. `take` tells whether that one takes its turn. Ends once `most` have taken theirs.
  template <class Sorted, class Take>
  void go_round(Sorted& all, std::size_t most, Take take) {
    std::size_t taken = 0;
    const auto offer = [&](auto from, auto to) {
      for (; from != to && taken < most; ++from) {
        if (!take(*from)) continue;
        last_ = key_of(*from);
        ++taken;
      }
    };
    const auto behind = last_ ? all.upper_bound(*last_) : all.begin();
    offer(behind, all.end());
    offer(all.begin(), behind);
  }

 private:
  static const Key& key_of(const Key& key) { return key; }
  template <class Value>
  static const Key& key_of(const std::pair<const Key, Value>& item) {
    return item.first;
  }

  std::optional<Key> last_;
};

}  // namespace sft::core
