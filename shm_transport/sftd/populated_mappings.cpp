#include "shm_transport/sftd/populated_mappings.h"

#include <sys/mman.h>

namespace sft::shm {

namespace {
/// The process may ask for so much other memory meanwhile.
constexpr std::size_t room_for_others = std::size_t{64} << 20;
}  // namespace

PopulatedMappings::PopulatedMappings(std::size_t bytes) {
  if (::mlockall(MCL_FUTURE) != 0) return;
  // A mapping fails if it exceeds the limit of locked memory. This one occupies nothing; it only finds out.
  const std::size_t all = bytes + room_for_others;
  void* const probe = ::mmap(nullptr, all, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  is_allowed_ = probe != MAP_FAILED;
  if (is_allowed_)
    ::munmap(probe, all);
  else
    ::munlockall();
}

PopulatedMappings::~PopulatedMappings() {
  if (is_allowed_) ::munlockall();
}

}  // namespace sft::shm
