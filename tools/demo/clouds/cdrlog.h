// Files of encoded messages: one (.cdr), or a log of them (.cdrlog: per record a u64 of time in ns, a u32 of
// length, and that many bytes; little-endian, nothing before, between or behind the records).
#pragma once

#include "tools/demo/clouds/input_cloud.h"

namespace sft::demo {

/// At most `limit` clouds. The time of a record is not used: the demo has a rate of its own.
Result<std::vector<InputCloud>> read_cdr(std::span<const std::byte> file, std::size_t limit);
Result<std::vector<InputCloud>> read_cdrlog(std::span<const std::byte> file, std::size_t limit);

}  // namespace sft::demo
