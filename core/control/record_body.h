// The bytes of records: an endpoint, what a subscriber asks for, or an inquiry; and those of reports. What
// comes from outside is checked here: lengths, roles, names. Pure.
//
// Numbers are written with the lowest octet first. A text is one octet with its length, and its octets; a
// list is four octets with its length, and its items. The members are in the order of record_body.cpp.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/control/control.h"
#include "sft/result.h"

namespace sft::core {

/// No record has more bytes.
inline constexpr std::size_t record_bytes_max = 131'072;
inline constexpr std::size_t report_bytes_max = 16'384;

/// What is longer than the bounds in control.h is cut, or left out if it makes no sense then. The request of
/// a subscriber is a record of its own. What does not travel is left out: the announcer.
std::vector<std::byte> to_bytes(const Endpoint& endpoint);
std::vector<std::byte> to_bytes(const Request& request);
std::vector<std::byte> to_bytes(const Inquiry& inquiry);
std::vector<std::byte> to_bytes(const NodeReport& report);

Result<Endpoint> endpoint_in(std::span<const std::byte> bytes);
Result<Request> request_in(std::span<const std::byte> bytes);
Result<Inquiry> inquiry_in(std::span<const std::byte> bytes);
Result<NodeReport> report_in(std::span<const std::byte> bytes);

}  // namespace sft::core
