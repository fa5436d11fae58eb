#include "core/negotiation/own_request.h"

#include <utility>
#include <vector>

#include "core/negotiation/id_list.h"

namespace sft::core {

bool OwnRequest::needs(const Selection& selection) {
  std::vector<std::uint64_t> words = selection.mask().to_words();
  std::vector<std::byte> parts;
  if (!selection.is_mask()) parts = selection.to_bytes();
  if (words == request_.mask_words && parts == request_.parts) return false;
  request_.mask_words = std::move(words);
  request_.parts = std::move(parts);
  ++request_.sequence;
  return true;
}

bool OwnRequest::takes_a_sample_per(std::uint32_t min_period_us) {
  if (request_.min_period_us == min_period_us) return false;
  request_.min_period_us = min_period_us;
  ++request_.sequence;
  return true;
}

bool OwnRequest::connection_changed(EndpointId writer, TransportKind path, bool connected) {
  std::vector<EndpointId>& writers = path == TransportKind::shm ? request_.attached : request_.listening;
  if (connected == holds(writers, writer)) return false;
  if (connected) {
    writers.push_back(writer);
  } else {
    std::erase(writers, writer);
    if (!holds(request_.listening, writer)) std::erase(request_.begun, writer);
  }
  ++request_.sequence;
  return true;
}

bool OwnRequest::history_began(EndpointId writer) {
  if (holds(request_.begun, writer)) return false;
  request_.begun.push_back(writer);
  ++request_.sequence;
  return true;
}

bool OwnRequest::memory_lost() {
  if (request_.attached.empty()) return false;
  request_.attached.clear();
  ++request_.sequence;
  return true;
}

}  // namespace sft::core
