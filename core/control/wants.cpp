#include "core/control/wants.h"

#include "sft/selection.h"

namespace sft::core {

namespace {

constexpr std::size_t head_bytes = 3;

void put(std::vector<std::byte>& wants, WantKind kind, std::span<const std::byte> bytes) {
  wants.push_back(static_cast<std::byte>(kind));
  wants.push_back(static_cast<std::byte>(bytes.size() & 0xFF));
  wants.push_back(static_cast<std::byte>(bytes.size() >> 8));
  wants.insert(wants.end(), bytes.begin(), bytes.end());
}

bool take_period(std::span<const std::byte> bytes, Request& request) {
  if (bytes.size() != sizeof request.min_period_us) return false;
  for (std::size_t i = bytes.size(); i-- > 0;)
    request.min_period_us = request.min_period_us << 8 | std::to_integer<std::uint32_t>(bytes[i]);
  return request.min_period_us != 0;
}

bool take_parts(std::span<const std::byte> bytes, Request& request) {
  request.parts.assign(bytes.begin(), bytes.end());
  return !bytes.empty() && bytes.size() <= Selection::bytes_max;
}

}  // namespace

std::vector<std::byte> wants_of(const Request& request) {
  std::vector<std::byte> wants;
  if (request.min_period_us != 0) {
    std::byte period[sizeof request.min_period_us];
    for (std::size_t i = 0; i < sizeof period; ++i)
      period[i] = static_cast<std::byte>(request.min_period_us >> 8 * i & 0xFF);
    put(wants, WantKind::period, period);
  }
  if (!request.parts.empty() && request.parts.size() <= Selection::bytes_max)
    put(wants, WantKind::parts, request.parts);
  return wants;
}

bool take_wants(std::span<const std::byte> wants, Request& request) {
  int last = 0;
  while (!wants.empty()) {
    if (wants.size() < head_bytes) return false;
    const int kind = std::to_integer<int>(wants[0]);
    const std::size_t bytes = std::to_integer<std::size_t>(wants[1]) | std::to_integer<std::size_t>(wants[2])
                                                                           << 8;
    if (kind <= last || wants.size() - head_bytes < bytes) return false;
    last = kind;
    const std::span<const std::byte> value = wants.subspan(head_bytes, bytes);
    if (kind == static_cast<int>(WantKind::period)) {
      if (!take_period(value, request)) return false;
    } else if (kind == static_cast<int>(WantKind::parts)) {
      if (!take_parts(value, request)) return false;
    } else if (kind < optional_wants) {
      return false;
    }
    wants = wants.subspan(head_bytes + bytes);
  }
  return true;
}

}  // namespace sft::core
