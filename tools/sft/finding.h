// What the doctor finds.
#pragma once

#include <cstdint>
#include <string>

namespace sft::tool {

enum class Health : std::uint8_t { ok, warning, error };

struct Finding {
  std::string what;  ///< "io_uring"
  Health health = Health::ok;
  std::string text;     ///< what was found
  std::string to_do{};  ///< empty where all is well
};

}  // namespace sft::tool
