#include "tests/simulation/negotiation/control_channels.h"

namespace sft::test {

void ControlChannels::close_to(std::size_t to) {
  std::erase_if(channels_, [to](const auto& channel) { return channel.first.second == to; });
}

std::vector<ControlChannels::Ends> ControlChannels::ends() const {
  std::vector<Ends> all;
  for (const auto& [ends, channel] : channels_) all.push_back(ends);
  return all;
}

void ControlChannels::send(std::size_t from, const Announcement& announcement) {
  for (auto& [ends, channel] : channels_) {
    if (ends.first == from && channel.found) post(channel, announcement);
  }
}

void ControlChannels::send(std::size_t from, const SentRequest& request) {
  for (auto& [ends, channel] : channels_) {
    if (ends.first == from && channel.found) post(channel, request);
  }
}

void ControlChannels::find(
    std::size_t from, std::size_t to, const std::map<core::EndpointId, SentRequest>& requests,
    const std::map<core::EndpointId, std::shared_ptr<const core::Endpoint>>& announced) {
  ControlChannel& channel = channels_.at({from, to});
  channel.found = true;
  for (const auto& [id, endpoint] : announced) post(channel, {id, endpoint});
  for (const auto& [id, request] : requests) post(channel, request);
}

Announcement ControlChannels::take_announcement(std::size_t from, std::size_t to) {
  ControlChannel& channel = channels_.at({from, to});
  channel.last_announcement = channel.announcements.front();
  channel.announcements.pop_front();
  return channel.last_announcement;
}

SentRequest ControlChannels::take_request(std::size_t from, std::size_t to) {
  ControlChannel& channel = channels_.at({from, to});
  const auto which = coin() ? static_cast<std::ptrdiff_t>((*random_)() % channel.requests.size()) : 0;
  channel.last_request = channel.requests[static_cast<std::size_t>(which)];
  channel.requests.erase(channel.requests.begin() + which);
  return channel.last_request;
}

ControlChannels::UnderWay ControlChannels::take_all(std::size_t from, std::size_t to) {
  ControlChannel& channel = channels_.at({from, to});
  return {std::exchange(channel.announcements, {}), std::exchange(channel.requests, {})};
}

void ControlChannels::post(ControlChannel& c, Announcement announcement) {
  if (random_ == nullptr || coin()) {
    std::erase_if(c.announcements, [&](const Announcement& a) { return a.id == announcement.id; });
  }
  c.announcements.push_back(std::move(announcement));
}

void ControlChannels::post(ControlChannel& c, SentRequest request) {
  if (random_ == nullptr || coin()) {
    std::erase_if(c.requests, [&](const auto& r) { return r->reader == request->reader; });
  }
  c.requests.push_back(std::move(request));
}

}  // namespace sft::test
