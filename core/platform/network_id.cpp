#include "core/platform/network_id.h"

#include <sys/stat.h>

#include <fstream>
#include <string>

#include "core/platform/random_id.h"
#include "sft/detail/fnv1a.h"

namespace sft::core {

std::uint64_t network_id() noexcept {
  std::string boot;
  std::getline(std::ifstream("/proc/sys/kernel/random/boot_id"), boot);
  struct stat space {};
  // Without /proc it is unknown which processes share the network of this process. With a random id, this
  // process seems to share its network with no other process, and no other host is mistaken for this host.
  if (boot.empty() || stat("/proc/self/ns/net", &space) != 0) return random_id();
  detail::Fnv1a hash;
  hash.add(boot);
  const std::uint64_t machine = hash.value() >> 32 << 32;
  hash.add(space.st_dev);
  hash.add(space.st_ino);
  return machine | static_cast<std::uint32_t>(hash.value() ^ hash.value() >> 32);
}

}  // namespace sft::core
