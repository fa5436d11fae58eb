#include "shm_transport/sftd/host_memory.h"

#include <grp.h>
#include <unistd.h>

namespace sft::shm {

using iox::roudi::RouDiMemoryManagerError;

Result<std::string> data_segment_name() {
  const group* own = getgrgid(getegid());
  if (own != nullptr) return std::string(own->gr_name);
  return fail(Errc::no_permission,
              "group " + std::to_string(getegid()) +
                  " has no entry in /etc/group, by which access to the memory is granted; add one");
}

iox::RouDiConfig_t make_config(const PoolPlan& plan, const std::string& segment_name) {
  iox::mepoo::MePooConfig pools;
  for (const Pool& pool : plan.pools) pools.addMemPool({static_cast<std::uint32_t>(pool.bytes), pool.count});
  iox::RouDiConfig_t config;
  const iox::posix::PosixGroup::string_t group(iox::cxx::TruncateToCapacity, segment_name);
  config.m_sharedMemorySegments.push_back({group, group, pools});
  return config;
}

HostMemory::HostMemory(const iox::RouDiConfig_t& config) : memory_(config) {
  std::ignore = memory_.m_managementShm.addMemoryBlock(&ports_);
  std::ignore = manager_.addMemoryProvider(&memory_.m_managementShm);
}

std::size_t HostMemory::management_bytes(const iox::RouDiConfig_t& config) {
  return HostMemory(config).management_bytes();
}

std::size_t HostMemory::management_bytes() const {
  constexpr std::size_t alignment_slack = 4096;
  return ports_.size() + memory_.m_introspectionMemPoolBlock.size() + memory_.m_segmentManagerBlock.size() +
         alignment_slack;
}

Result<std::unique_ptr<HostMemory>> HostMemory::make(const iox::RouDiConfig_t& config) {
  std::unique_ptr<HostMemory> memory(new HostMemory(config));
  if (memory->createAndAnnounceMemory().has_error()) {
    return fail(Errc::out_of_memory, "the segments in /dev/shm could not be created; is there space left?");
  }
  return memory;
}

std::uint64_t HostMemory::port_pool_offset() const {
  const auto* base = static_cast<const std::byte*>(*memory_.m_managementShm.baseAddress());
  return static_cast<std::uint64_t>(reinterpret_cast<const std::byte*>(*ports_.portPool()) - base);
}

iox::cxx::expected<RouDiMemoryManagerError> HostMemory::createAndAnnounceMemory() noexcept {
  auto created = manager_.createAndAnnounceMemory();
  if (!created.has_error() && ports_.portPool().has_value()) port_pool_.emplace(*ports_.portPool().value());
  return created;
}

iox::cxx::expected<RouDiMemoryManagerError> HostMemory::destroyMemory() noexcept {
  return manager_.destroyMemory();
}

const iox::roudi::PosixShmMemoryProvider* HostMemory::mgmtMemoryProvider() const noexcept {
  return &memory_.m_managementShm;
}

iox::cxx::optional<iox::roudi::PortPool*> HostMemory::portPool() noexcept {
  if (!port_pool_.has_value()) return iox::cxx::nullopt;
  return iox::cxx::make_optional<iox::roudi::PortPool*>(&port_pool_.value());
}

iox::cxx::optional<iox::mepoo::MemoryManager*> HostMemory::introspectionMemoryManager() const noexcept {
  return memory_.m_introspectionMemPoolBlock.memoryManager();
}

iox::cxx::optional<iox::mepoo::SegmentManager<>*> HostMemory::segmentManager() const noexcept {
  return memory_.m_segmentManagerBlock.segmentManager();
}

}  // namespace sft::shm
