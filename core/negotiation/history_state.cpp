#include "core/negotiation/history_state.h"

#include <algorithm>

namespace sft::core {

bool HistoryState::given(EndpointId writer, const Endpoint& reader) {
  return holds(reader.request.begun, writer) && given_.insert({writer, reader.id}).second;
}

std::uint32_t HistoryState::owed(const Endpoint& writer, const Endpoint& reader) const {
  const bool durable = writer.qos.durability == Durability::transient_local &&
                       reader.qos.durability == Durability::transient_local;
  if (!durable || given_.contains({writer.id, reader.id})) return 0;
  return std::min(writer.qos.history_depth, reader.qos.history_depth);
}

void HistoryState::begins_anew(const Endpoint& reader) {
  if (reader.qos.durability == Durability::volatile_) return;
  std::erase_if(given_, [&](const PairId& pair) {
    return pair.reader == reader.id && !holds(reader.request.begun, pair.writer);
  });
}

void HistoryState::disconnected(const Endpoint& reader, EndpointId writer) {
  if (!holds(reader.request.listening, writer)) came_.erase({writer, reader.id});
  begins_anew(reader);
}

void HistoryState::forget(EndpointId id) {
  std::erase_if(given_, [&](const PairId& pair) { return pair.writer == id || pair.reader == id; });
  std::erase_if(came_, [&](const PairId& pair) { return pair.reader == id; });
}

}  // namespace sft::core
