#include "core/platform/random_id.h"

#include <sys/random.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>

namespace sft::core {

std::uint64_t random_id() noexcept {
  std::uint64_t id = 0;
  while (id == 0) {
    if (getrandom(&id, sizeof id, 0) == sizeof id) continue;
    const auto now = static_cast<std::uint64_t>(std::chrono::steady_clock::now().time_since_epoch().count());
    id = now * 0x9e3779b97f4a7c15 ^ static_cast<std::uint64_t>(getpid()) << 32 ^
         reinterpret_cast<std::uintptr_t>(&id);
  }
  return id;
}

std::string in_hex(std::uint64_t id) {
  char digits[17];
  std::snprintf(digits, sizeof digits, "%016llx", static_cast<unsigned long long>(id));
  return digits;
}

}  // namespace sft::core
