// The reason why a daemon cannot start.
#pragma once

#include <string>
#include <tl/expected.hpp>
#include <utility>

#include "shm_transport/sftd/exit_code.h"

namespace sft::shm {

struct StartFailure {
  ExitCode code;
  std::string message;
};

inline tl::unexpected<StartFailure> refuse(ExitCode code, std::string message) {
  return tl::unexpected(StartFailure{code, std::move(message)});
}

}  // namespace sft::shm
