#include "core/discovery/requests_in_advance.h"

#include <algorithm>

namespace sft::core {

void RequestsInAdvance::keep(const Speaker& speaker, Request request, Time now) {
  std::erase_if(requests_, [&](const Early& early) {
    return early.request.reader == request.reader && early.speaker == speaker;
  });
  const auto of_reader =
      std::ranges::count(requests_, request.reader, [](const Early& early) { return early.request.reader; });
  if (of_reader >= of_a_reader_max) return;
  if (requests_.size() >= most_) requests_.erase(requests_.begin());
  requests_.push_back({speaker, std::move(request), now});
}

std::optional<Request> RequestsInAdvance::take(const Speaker& speaker, EndpointId reader) {
  const auto found = std::ranges::find_if(requests_, [&](const Early& early) {
    return early.request.reader == reader && early.speaker == speaker;
  });
  if (found == requests_.end()) return std::nullopt;
  Request request = std::move(found->request);
  requests_.erase(found);
  return request;
}

void RequestsInAdvance::forget_link(LinkId link) {
  std::erase_if(requests_, [&](const Early& early) { return early.speaker.link == link; });
}

}  // namespace sft::core
