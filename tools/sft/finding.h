// One result of `sft doctor`.
#pragma once

#include <cstdint>
#include <string>

namespace sft::tool {

enum class Health : std::uint8_t { ok, warning, error };

struct Finding {
  std::string what;  ///< the name of the check, such as "io_uring"
  Health health = Health::ok;
  std::string text;     ///< the state that the check found
  std::string to_do{};  ///< the way to correct the state; empty if there is no fault
};

}  // namespace sft::tool
