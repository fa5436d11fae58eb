#include "core/platform/network_id.h"

#include <sys/stat.h>

#include <fstream>
#include <string>

#include "sft/detail/fnv1a.h"

namespace sft::core {

std::optional<std::uint64_t> network_id() noexcept {
  std::string boot;
  std::getline(std::ifstream("/proc/sys/kernel/random/boot_id"), boot);
  struct stat space {};
  if (boot.empty() || stat("/proc/self/ns/net", &space) != 0) return {};
  detail::Fnv1a hash;
  hash.add(boot);
  const std::uint64_t machine = hash.value() >> 32 << 32;
  hash.add(space.st_dev);
  hash.add(space.st_ino);
  return machine | static_cast<std::uint32_t>(hash.value() ^ hash.value() >> 32);
}

}  // namespace sft::core
