// Opens the eventfd by which other threads wake a thread that waits in a system call.
#pragma once

#include "core/platform/file_descriptor.h"
#include "sft/result.h"

namespace sft::udp {

/// Opens an eventfd that does not block. Programs that this process starts do not inherit it.
Result<core::FileDescriptor> open_wake_event();

}  // namespace sft::udp
