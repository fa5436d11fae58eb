#include "core/discovery/kept_words.h"

#include <variant>

namespace sft::core {

namespace {

std::size_t bytes_behind(const Request& request) {
  return (request.mask_words.size() + request.listening.size() + request.attached.size() +
          request.begun.size()) *
         sizeof(std::uint64_t);
}

std::size_t bytes_behind(const Endpoint& endpoint) {
  return endpoint.node.size() + endpoint.topic.size() + endpoint.type_name.size() +
         endpoint.type_description.size() + endpoint.addresses.size() * sizeof(UdpAddress) +
         bytes_behind(endpoint.request);
}

/// What a word takes, roughly.
std::size_t bytes_of(const ControlWord& word) {
  std::size_t bytes = 2 * sizeof word;
  if (const auto* const endpoint = std::get_if<Endpoint>(&word.what)) bytes += bytes_behind(*endpoint);
  if (const auto* const request = std::get_if<Request>(&word.what)) bytes += bytes_behind(*request);
  return bytes;
}

}  // namespace

void KeptWords::learn(const Word& word) {
  if (const auto* const unheard = std::get_if<EndpointUnheard>(&word->what)) return drop_all_of(unheard->id);
  if (!word->speaker) return;
  const Participants::Guid& speaker = *word->speaker;
  if (const auto* const endpoint = std::get_if<Endpoint>(&word->what)) {
    keep({Kind::announcement, endpoint->id, speaker}, word);
  } else if (const auto* const request = std::get_if<Request>(&word->what)) {
    keep({Kind::request, request->reader, speaker}, word);
  } else if (const auto* const withdrawn = std::get_if<EndpointWithdrawn>(&word->what)) {
    for (const Kind kind : {Kind::announcement, Kind::request})
      drop(words_.find({kind, withdrawn->id, speaker}));
  }
}

void KeptWords::forget(const Participants::Guid& participant) {
  if (!counts_.contains(participant)) return;  // each node of the process tells of the same participants
  for (auto kept = words_.begin(); kept != words_.end();) {
    const auto next = std::next(kept);
    if (std::get<Participants::Guid>(kept->first) == participant) drop(kept);
    kept = next;
  }
}

void KeptWords::clear() {
  words_.clear();
  counts_.clear();
  bytes_ = 0;
  are_complete_ = true;
}

std::vector<KeptWords::Word> KeptWords::all() const {
  std::vector<Word> all;
  all.reserve(words_.size());
  for (const auto& [key, word] : words_) all.push_back(word);
  return all;
}

void KeptWords::keep(const Key& key, const Word& word) {
  if (!are_complete_) return;
  drop(words_.find(key));
  bytes_ += bytes_of(*word);
  words_.emplace(key, word);
  ++counts_[std::get<Participants::Guid>(key)];
  if (bytes_ <= bytes_max_) return;
  clear();
  are_complete_ = false;
}

void KeptWords::drop(std::map<Key, Word>::iterator kept) {
  if (kept == words_.end()) return;
  bytes_ -= bytes_of(*kept->second);
  const auto count = counts_.find(std::get<Participants::Guid>(kept->first));
  if (--count->second == 0) counts_.erase(count);
  words_.erase(kept);
}

void KeptWords::drop_all_of(EndpointId id) {
  for (const Kind kind : {Kind::announcement, Kind::request}) {
    auto kept = words_.lower_bound({kind, id, {}});
    while (kept != words_.end() && std::get<Kind>(kept->first) == kind &&
           std::get<EndpointId>(kept->first) == id) {
      const auto next = std::next(kept);
      drop(kept);
      kept = next;
    }
  }
}

}  // namespace sft::core
