#include "udp_transport/unfinished_sample.h"

#include <cstring>
#include <utility>

namespace sft::udp {

void UnfinishedSample::begin(const SampleLabel& label, Time now) {
  clear();
  first_ = {};
  first_.label = label;
  last_progress_ = now;
}

void UnfinishedSample::describe(const FirstHeader& first, std::size_t body_offset,
                                core::SampleHandle buffer) {
  first_ = first;
  body_ = buffer->data + body_offset;
  buffer_ = std::move(buffer);
}

bool UnfinishedSample::add(std::uint32_t offset, std::span<const std::byte> payload, Time now) {
  if (offset > first_.total || payload.size() > first_.total - offset) return false;
  if (payload.empty()) return true;
  if (received_.add(offset, offset + static_cast<std::uint32_t>(payload.size())) == 0)
    return true;  // repeated
  std::memcpy(body_ + offset, payload.data(), payload.size());
  last_progress_ = now;
  return true;
}

void UnfinishedSample::park(std::uint32_t offset, std::span<const std::byte> payload, Time now) {
  const Parked parked{offset, static_cast<std::uint32_t>(payload.size())};
  const std::size_t at = parked_.size();
  parked_.resize(at + bytes_to_park(payload));
  std::memcpy(&parked_[at], &parked, sizeof parked);
  std::memcpy(&parked_[at + sizeof parked], payload.data(), payload.size());
  last_progress_ = now;
}

bool UnfinishedSample::unpark(Time now) {
  bool all_fit = true;
  for (std::size_t at = 0; at < parked_.size();) {
    Parked parked;
    std::memcpy(&parked, &parked_[at], sizeof parked);
    at += sizeof parked;
    all_fit = add(parked.offset, std::span(parked_).subspan(at, parked.bytes), now) && all_fit;
    at += parked.bytes;
  }
  parked_ = {};
  return all_fit;
}

void UnfinishedSample::clear() {
  place_ = 0;
  buffer_.reset();
  body_ = nullptr;
  received_.clear();
  parked_ = {};
}

}  // namespace sft::udp
