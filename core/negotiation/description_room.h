// Limits the bytes of type descriptions that a table keeps of others' endpoints, which somebody may announce
// without end. An endpoint for whose description there is no room is kept without it: pairs match all the
// same, but nobody knows the fields. Who has no room takes none from others. Pure.
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

  /// Takes the description away if there is no room for it.
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
  /// The endpoint goes, as it was after enter().
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
