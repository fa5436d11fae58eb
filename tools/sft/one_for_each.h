// One thing for each of some keys that come and go.
#pragma once

#include <map>
#include <set>
#include <utility>

namespace sft::tool {

/// Makes a thing for each key that has none yet, and drops those of keys that are not wanted any more.
/// make(key) returns a Result; if there is an error, it is called again next time.
template <class Key, class Thing, class Make>
void keep_one_for_each(const std::set<Key>& wanted, std::map<Key, Thing>& things, Make make) {
  std::erase_if(things, [&](const auto& item) { return !wanted.contains(item.first); });
  for (const Key& key : wanted) {
    if (things.contains(key)) continue;
    if (auto made = make(key)) things.emplace(key, *std::move(made));
  }
}

}  // namespace sft::tool
