// Encodes and decodes records (of an endpoint, a request or an inquiry) and reports. Bytes from other
// processes are checked here: lengths, roles, names. Uses no clock, thread or I/O.
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

/// The largest sizes of a record and of a report, in bytes.
inline constexpr std::size_t record_bytes_max = 131'072;
inline constexpr std::size_t report_bytes_max = 16'384;

/// These functions encode a record or report. Texts and lists that exceed the bounds in control.h are cut.
/// They are left out if they would be meaningless when cut. The request of a subscriber is a separate
/// record.
std::vector<std::byte> to_bytes(const Endpoint& endpoint);
std::vector<std::byte> to_bytes(const Request& request);
std::vector<std::byte> to_bytes(const Inquiry& inquiry);
std::vector<std::byte> to_bytes(const NodeReport& report);

Result<Endpoint> endpoint_in(std::span<const std::byte> bytes);
Result<Request> request_in(std::span<const std::byte> bytes);
Result<Inquiry> inquiry_in(std::span<const std::byte> bytes);
Result<NodeReport> report_in(std::span<const std::byte> bytes);

}  // namespace sft::core
