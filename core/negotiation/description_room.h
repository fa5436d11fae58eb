// Limits the total size of the type descriptions that a table keeps for endpoints of other nodes, since a
// hostile node may announce any number of endpoints. If a description would exceed the limit, its endpoint
// is kept without the description. Pairs of the endpoint match nevertheless, but the fields of its type are
// not known. A description never replaces another one. Uses no clock, thread or I/O.
#pragma once

#include <cstddef>
#include <map>
#include <vector>

#include "core/control/control.h"

namespace sft::core {

class DescriptionRoom {
 public:
  static constexpr std::size_t description_bytes_max = std::size_t{32} << 20;
  static constexpr std::size_t description_bytes_of_announcer = std::size_t{8} << 20;

  /// Counts the description of a new endpoint, or removes it from the endpoint if it would exceed the
  /// limit.
  void enter(Endpoint& endpoint) {
    const std::size_t bytes = endpoint.type_description.size();
    if (bytes == 0) return;
    const auto known = of_.find(endpoint.announcer);
    const std::size_t own = known == of_.end() ? 0 : known->second;
    if (own + bytes > description_bytes_of_announcer || all_ + bytes > description_bytes_max) {
      endpoint.type_description = std::vector<std::byte>();
      return;
    }
    all_ += bytes;
    of_[endpoint.announcer] += bytes;
  }
  /// Called when the endpoint is removed. The endpoint must have the same description as after enter().
  void leave(const Endpoint& endpoint) {
    const std::size_t bytes = endpoint.type_description.size();
    if (bytes == 0) return;
    all_ -= bytes;
    const auto own = of_.find(endpoint.announcer);
    own->second -= bytes;
    if (own->second == 0) of_.erase(own);
  }

 private:
  std::size_t all_ = 0;
  std::map<AnnouncerId, std::size_t> of_;
};

}  // namespace sft::core
