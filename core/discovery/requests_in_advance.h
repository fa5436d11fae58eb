// Requests that came before the announcement of their reader, for a while and a limited number of them. Pure.
#pragma once

#include <chrono>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "core/control/control.h"
#include "core/discovery/speakers.h"
#include "core/platform/clock.h"

namespace sft::core {

class RequestsInAdvance {
 public:
  explicit RequestsInAdvance(std::size_t most) : most_(most) {}

  /// Only the newest one of each speaker for a reader is kept, and the oldest one gives way if there are too
  /// many.
  void keep(const Speaker& speaker, Request request, Time now);
  /// The request of a reader that the speaker announces now, if there is one.
  std::optional<Request> take(const Speaker& speaker, EndpointId reader);
  bool empty() const { return requests_.empty(); }
  void forget_link(LinkId link);
  /// Forgets each request for which forgets(reader, age) is true.
  template <class Forgets>
  void forget_if(Forgets forgets, Time now) {
    std::erase_if(requests_,
                  [&](const Early& early) { return forgets(early.request.reader, now - early.at); });
  }

 private:
  static constexpr std::ptrdiff_t of_a_reader_max = 4;

  struct Early {
    Speaker speaker;
    Request request;
    Time at;
  };
  const std::size_t most_;
  std::vector<Early> requests_;
};

}  // namespace sft::core
