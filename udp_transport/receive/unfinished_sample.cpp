#include "udp_transport/receive/unfinished_sample.h"

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

UnfinishedSample::Added UnfinishedSample::add(std::uint32_t offset, std::span<const std::byte> payload,
                                              std::size_t gaps_max, Time now) {
  if (offset > first_.total || payload.size() > first_.total - offset) return Added::beyond_body;
  if (payload.empty()) return Added::yes;
  const std::uint32_t end = offset + static_cast<std::uint32_t>(payload.size());
  if (received_.intervals().size() >= gaps_max && received_.stands_alone(offset, end))
    return Added::too_many_gaps;
  if (received_.add(offset, end) == 0) return Added::yes;  // all bytes have come before
  std::memcpy(body_ + offset, payload.data(), payload.size());
  last_progress_ = now;
  return Added::yes;
}

void UnfinishedSample::park(std::uint32_t offset, std::span<const std::byte> payload, Time now) {
  const Parked parked{offset, static_cast<std::uint32_t>(payload.size())};
  const std::size_t at = parked_.size();
  parked_.resize(at + bytes_to_park(payload));
  std::memcpy(&parked_[at], &parked, sizeof parked);
  std::memcpy(&parked_[at + sizeof parked], payload.data(), payload.size());
  last_progress_ = now;
}

UnfinishedSample::Added UnfinishedSample::unpark(std::size_t gaps_max, Time now) {
  Added all = Added::yes;
  for (std::size_t at = 0; at < parked_.size();) {
    Parked parked;
    std::memcpy(&parked, &parked_[at], sizeof parked);
    at += sizeof parked;
    const Added one = add(parked.offset, std::span(parked_).subspan(at, parked.bytes), gaps_max, now);
    if (one != Added::yes) all = one;
    at += parked.bytes;
  }
  parked_ = std::vector<std::byte>();  // `{}` would keep the memory
  return all;
}

void UnfinishedSample::clear() {
  place_ = 0;
  buffer_.reset();
  body_ = nullptr;
  received_.clear();
  parked_ = std::vector<std::byte>();  // `{}` would keep the memory
}

}  // namespace sft::udp
