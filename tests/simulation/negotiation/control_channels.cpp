#include "tests/simulation/negotiation/control_channels.h"

#include <algorithm>

namespace sft::test {

void ControlChannels::close_to(std::size_t to) {
  std::erase_if(channels_, [to](const auto& channel) { return channel.first.second == to; });
}

std::vector<ControlChannels::Ends> ControlChannels::ends() const {
  std::vector<Ends> all;
  for (const auto& [ends, channel] : channels_) all.push_back(ends);
  return all;
}

void ControlChannels::send(std::size_t from, const Word& word) {
  for (auto& [ends, channel] : channels_) {
    if (ends.first == from && channel.found) post(channel, word);
  }
}

/// Posts each announced endpoint together with the request in force.
void ControlChannels::find(
    std::size_t from, std::size_t to, const std::map<core::EndpointId, SentRequest>& requests,
    const std::map<core::EndpointId, std::shared_ptr<const core::Endpoint>>& announced) {
  ControlChannel& channel = channels_.at({from, to});
  channel.found = true;
  for (const auto& [id, endpoint] : announced) {
    auto found = std::make_shared<core::Endpoint>(*endpoint);
    if (const auto request = requests.find(id); request != requests.end()) found->request = *request->second;
    post(channel, {.id = id, .endpoint = std::move(found)});
  }
}

Word ControlChannels::take(std::size_t from, std::size_t to) {
  ControlChannel& channel = channels_.at({from, to});
  const std::size_t which = coin() ? (*random_)() % channel.words.size() : 0;
  const auto first = std::ranges::find(channel.words, channel.words[which].id, &Word::id);
  channel.last = *first;
  channel.words.erase(first);
  return channel.last;
}

std::deque<Word> ControlChannels::take_all(std::size_t from, std::size_t to) {
  return std::exchange(channels_.at({from, to}).words, {});
}

/// Posts a message, which may replace earlier messages about the same endpoint. A request replaces only
/// requests. An announcement replaces both kinds, because it contains the request in force.
void ControlChannels::post(ControlChannel& channel, Word word) {
  if (random_ == nullptr || coin()) {
    std::erase_if(channel.words, [&](const Word& before) {
      return before.id == word.id && (word.request == nullptr || before.request != nullptr);
    });
  }
  channel.words.push_back(std::move(word));
}

}  // namespace sft::test
