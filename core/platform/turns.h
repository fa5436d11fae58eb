// Selects participants in turn (round robin) if not all of them can be served at once. Uses no clock,
// thread or I/O.
#pragma once

#include <cstddef>
#include <optional>
#include <utility>

namespace sft::core {

/// `Key` identifies the participants, and defines their order.
template <class Key>
class Turns {
 public:
  /// Offers a turn to each participant in `all`, which is a set of keys or a map with them. The first offer
  /// is to the participant after the one that took the last turn. `take` returns true if the participant
  /// takes its turn. The function returns once `most` participants have taken a turn, or when all have been
  /// asked.
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
