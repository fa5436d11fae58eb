// Limits the bytes of type descriptions that a table keeps of the endpoints of other nodes, since a hostile
// node may announce any number of endpoints. If there is no room for a description, its endpoint is kept
// without it. Pairs match nevertheless, but the fields are not known. A description never replaces another
// one. Uses no clock, thread or I/O.
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

  /// Counts the description of a new endpoint, or removes it from the endpoint if there is no room for it.
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
  /// Called when the endpoint is removed. It has the description that it had after enter().
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
