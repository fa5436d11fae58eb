#include "core/negotiation/early_requests.h"

#include <algorithm>

namespace sft::core {

bool EarlyRequests::keep(const Request& request) {
  const auto reader = requests_.find(request.reader);
  if (reader != requests_.end()) {
    const auto known = reader->second.find(request.announcer);
    if (known != reader->second.end() && request.sequence <= known->second.request.sequence) return false;
  }
  erase(request.reader, request.announcer);
  const bool full = size_ >= most_;
  if (full) make_room();
  requests_[request.reader][request.announcer] = {request, ++arrivals_};
  announcers_[request.announcer][arrivals_] = request.reader;
  ++size_;
  return full;
}

void EarlyRequests::make_room() {
  const auto most = std::ranges::max_element(announcers_, {},
                                             [](const auto& announcer) { return announcer.second.size(); });
  erase(most->second.begin()->second, most->first);
}

std::vector<Request> EarlyRequests::take(EndpointId reader, AnnouncerId announcer) {
  std::vector<Request> taken;
  const auto found = requests_.find(reader);
  if (found == requests_.end()) return taken;
  if (const auto own = found->second.find(announcer); own != found->second.end()) {
    taken.push_back(std::move(own->second.request));
  } else {
    for (auto& [who, early] : found->second) taken.push_back(std::move(early.request));
  }
  forget(reader);
  return taken;
}

void EarlyRequests::forget(EndpointId reader) {
  for (auto found = requests_.find(reader); found != requests_.end(); found = requests_.find(reader))
    erase(reader, AnnouncerId{found->second.begin()->first});
}

void EarlyRequests::erase(EndpointId reader, AnnouncerId announcer) {
  const auto found = requests_.find(reader);
  if (found == requests_.end()) return;
  const auto early = found->second.find(announcer);
  if (early == found->second.end()) return;
  const auto own = announcers_.find(announcer);
  own->second.erase(early->second.arrival);
  if (own->second.empty()) announcers_.erase(own);
  found->second.erase(early);
  if (found->second.empty()) requests_.erase(found);
  --size_;
}

}  // namespace sft::core
