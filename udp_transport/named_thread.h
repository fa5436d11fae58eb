// Threads of the transport: named for debuggers, and never the ones that get the process's signals.
#pragma once

#include <functional>
#include <string>
#include <thread>

#include "sft/typesupport/result.h"

namespace sft::udp {

/// At most 15 characters of the name are used.
Result<std::thread> start_thread(const std::string& name, std::function<void()> body);

}  // namespace sft::udp
