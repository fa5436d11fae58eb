// Keeps leaves in the order in which they were last read. So the leaf that has not been read for the longest
// time is found in constant time. The order is a linked list within an array. Nothing is allocated after
// construction.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace sft::core {

class ReadOrder {
 public:
  explicit ReadOrder(std::size_t leaves) : links_(leaves + 1) {
    for (std::size_t i = 0; i < links_.size(); ++i) unlink(i);
  }

  bool empty() const { return !contains(end()); }
  bool contains(std::size_t leaf) const { return links_[leaf].newer != leaf; }
  /// Returns the leaf that has not been read for the longest time. REQUIRES: the list is not empty.
  std::size_t oldest() const { return links_.back().newer; }

  /// Adds the leaf at the end of the order, or moves it there.
  void was_read(std::size_t leaf) {
    remove(leaf);
    const std::uint32_t newest = links_.back().older;
    links_[leaf] = {newest, static_cast<std::uint32_t>(end())};
    links_[newest].newer = links_.back().older = static_cast<std::uint32_t>(leaf);
  }
  void remove(std::size_t leaf) {
    const Link link = links_[leaf];
    links_[link.older].newer = link.newer;
    links_[link.newer].older = link.older;
    unlink(leaf);
  }

 private:
  struct Link {
    std::uint32_t older = 0;
    std::uint32_t newer = 0;
  };
  /// Returns the index of the last link, which closes the ring.
  std::size_t end() const { return links_.size() - 1; }
  /// Makes link `i` a ring by itself, like the link of each leaf that is not in the list.
  void unlink(std::size_t i) { links_[i] = {static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(i)}; }

  std::vector<Link> links_;
};

}  // namespace sft::core
