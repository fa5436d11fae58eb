// Maintains one object for each key of a changing set.
#pragma once

#include <map>
#include <set>
#include <utility>

namespace sft::tool {

/// Makes an object for each wanted key that has none yet, and removes the objects of keys that are not
/// wanted any more. make(key) returns a Result. If it is an error, make(key) is called again in the next
/// call.
template <class Key, class Thing, class Make>
void keep_one_for_each(const std::set<Key>& wanted, std::map<Key, Thing>& things, Make make) {
  std::erase_if(things, [&](const auto& item) { return !wanted.contains(item.first); });
  for (const Key& key : wanted) {
    if (things.contains(key)) continue;
    if (auto made = make(key)) things.emplace(key, *std::move(made));
  }
}

}  // namespace sft::tool
