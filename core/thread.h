// How all threads of a node are started: named for debuggers, never the ones that get the process's signals,
// and where the system gives no more of them that is an error and no exception.
#pragma once

#include <functional>
#include <string>
#include <thread>

#include "sft/typesupport/result.h"

namespace sft::core {

/// At most 15 characters of the name are used.
Result<std::thread> start_thread(const std::string& name, std::function<void()> body);

}  // namespace sft::core
