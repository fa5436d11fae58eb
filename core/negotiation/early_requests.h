// Requests of readers that have yet to be seen, or seen again: the newest of each reader and announcer. A
// request never comes a second time. Where there are too many, the announcer that has the most loses the one
// that has waited longest, whose reader is the least likely to come. Pure.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <vector>

#include "core/control/control.h"

namespace sft::core {

class EarlyRequests {
 public:
  explicit EarlyRequests(std::size_t most) : most_(most) {}

  /// Returns whether another one was dropped for it.
  bool keep(const Request& request);
  /// The one of that announcer for that reader, or, if there is none, those of all others. All of the reader
  /// are forgotten.
  std::vector<Request> take(EndpointId reader, AnnouncerId announcer);
  void forget(EndpointId reader);

 private:
  struct Early {
    Request request;
    std::uint64_t arrival = 0;
  };
  using OfReader = std::map<AnnouncerId, Early>;
  void erase(EndpointId reader, AnnouncerId announcer);
  void make_room();

  std::size_t most_;
  std::map<EndpointId, OfReader> requests_;
  std::map<AnnouncerId, std::map<std::uint64_t, EndpointId>> announcers_;  ///< readers by arrival
  std::size_t size_ = 0;
  std::uint64_t arrivals_ = 0;
};

}  // namespace sft::core
