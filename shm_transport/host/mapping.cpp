#include "shm_transport/host/mapping.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>

#include <cerrno>
#include <cstdint>
#include <cstring>

#include "core/platform/trusted_file.h"
#include "shm_transport/host/membership.h"

namespace sft::shm {

bool contains(std::span<const std::byte> memory, const void* data, std::size_t size) {
  const auto at = reinterpret_cast<std::uintptr_t>(data) - reinterpret_cast<std::uintptr_t>(memory.data());
  return at <= memory.size() && size <= memory.size() - at;
}

Result<Mapping> Mapping::open(const std::string& name, std::size_t bytes, bool writable, uid_t owner) {
  const std::string path = "/dev/shm/" + name;
  auto file = core::open_trusted_file(path, writable ? O_RDWR : O_RDONLY, {.users = {owner}});
  if (!file) {
    struct stat there {};
    const bool is_forbidden = file.error().code == Errc::no_permission && lstat(path.c_str(), &there) == 0;
    return fail(file.error().code,
                file.error().message +
                    (is_forbidden ? "; " + how_to_join(Membership::of_this_process(there.st_gid)) : ""));
  }
  struct stat status {};
  if (fstat(file->get(), &status) != 0 || static_cast<std::size_t>(status.st_size) < bytes)
    return fail(Errc::malformed, path + " is shorter than sftd said");
  void* memory =
      mmap(nullptr, bytes, writable ? PROT_READ | PROT_WRITE : PROT_READ, MAP_SHARED, file->get(), 0);
  if (memory == MAP_FAILED) return fail(Errc::out_of_memory, path + ": " + std::strerror(errno));
  // Without this call, a core dump would contain the memory even after the file's name was removed.
  madvise(memory, bytes, MADV_DONTDUMP);
  return Mapping({static_cast<std::byte*>(memory), bytes}, status.st_gid,
                 writable ? std::move(*file) : core::FileDescriptor());
}

Mapping::~Mapping() {
  if (!memory_.empty()) munmap(memory_.data(), memory_.size());
}

}  // namespace sft::shm
