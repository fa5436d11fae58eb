#include "shm_transport/sftd/host_memory.h"

#include <sys/mman.h>
#include <unistd.h>

#include "shm_transport/host/pool_layout.h"

namespace sft::shm {

using iox::roudi::RouDiMemoryManagerError;

iox::RouDiConfig_t make_config(const PoolPlan& plan, const Groups& groups) {
  iox::mepoo::MePooConfig pools;
  for (const Pool& pool : plan.pools) pools.addMemPool({static_cast<std::uint32_t>(pool.bytes), pool.count});
  iox::RouDiConfig_t config;
  using Name = iox::posix::PosixGroup::string_t;
  const Name writers(iox::cxx::TruncateToCapacity, groups.writers);
  const Name readers(iox::cxx::TruncateToCapacity, groups.readers);
  config.m_sharedMemorySegments.push_back({groups.reader_id ? readers : writers, writers, pools});
  return config;
}

HostMemory::HostMemory(const iox::RouDiConfig_t& config)
    : introspection_(iox::roudi::DefaultRouDiMemory(config).introspectionMemPoolConfig()),
      sample_block_(config),
      management_(iox::roudi::SHM_NAME, iox::posix::AccessMode::READ_WRITE,
                  iox::posix::OpenMode::OPEN_EXISTING) {
  for (iox::roudi::MemoryBlock* const block : blocks()) std::ignore = management_.addMemoryBlock(block);
  std::ignore = manager_.addMemoryProvider(&management_);
}

std::array<iox::roudi::MemoryBlock*, 3> HostMemory::blocks() {
  return {&introspection_, &sample_block_, &ports_};
}

std::size_t HostMemory::management_bytes(const iox::RouDiConfig_t& config) {
  return HostMemory(config).management_file_bytes();
}

std::size_t HostMemory::management_file_bytes() {
  constexpr std::size_t alignment_slack = 4096;
  std::size_t sum = alignment_slack;
  for (const iox::roudi::MemoryBlock* const block : blocks()) sum += block->size();
  return sum;
}

Result<std::unique_ptr<HostMemory>> HostMemory::make(const PoolPlan& plan, const Groups& groups) {
  const iox::RouDiConfig_t config = make_config(plan, groups);
  std::unique_ptr<HostMemory> memory(new HostMemory(config));
  auto management = make_segment_file(iox::roudi::SHM_NAME, memory->management_file_bytes());
  if (!management) return tl::unexpected(management.error());
  memory->files_.push_back(std::move(*management));
  auto samples = make_segment_file_without_memory(groups.writers, SampleBlock::file_bytes(config));
  if (!samples) return tl::unexpected(samples.error());
  memory->files_.push_back(std::move(*samples));
  if (memory->createAndAnnounceMemory().has_error() || !memory->find_samples(groups.member))
    return fail(Errc::out_of_memory, "the segments in /dev/shm could not be mapped");
  // No program has used a chunk yet.
  SegmentFile& of_samples = memory->files_.back();
  of_samples.on_demand = memory->parts_on_demand(plan);
  if (auto done = set_aside(of_samples, groups.writers); !done) return tl::unexpected(done.error());
  return memory;
}

/// Returns the parts of the file that get memory on demand. Pages with headers of chunks are left out,
/// because iceoryx writes the header when it lends the chunk.
std::vector<FilePart> HostMemory::parts_on_demand(const PoolPlan& plan) const {
  const auto page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
  const std::vector<PoolLayout> layouts = pools_of(*samples_.pools);
  std::vector<FilePart> parts;
  for (std::size_t i = 0; i < plan.pools.size(); ++i) {
    const Pool& pool = plan.pools[i];
    for (std::uint32_t chunk = pool.count - pool.on_demand; chunk < pool.count; ++chunk) {
      const auto offset = static_cast<std::size_t>(layouts[i].at(chunk) - samples_.memory.data());
      const std::size_t begin = (offset + chunk_header_bytes + page - 1) / page * page;
      const std::size_t end = (offset + layouts[i].chunk_bytes()) / page * page;
      if (begin < end) parts.push_back({begin, end - begin});
    }
  }
  return parts;
}

bool HostMemory::find_samples(uid_t member) {
  auto& segments = *segmentManager().value();
  const iox::posix::PosixUser user(member);
  const auto mappings = segments.getSegmentMappings(user);
  auto writable = segments.getSegmentInformationWithWriteAccessForUser(user);
  if (mappings.empty() || !writable.m_memoryManager.has_value()) return false;
  const auto& mapping = mappings[0];
  samples_ = {mapping.m_segmentId,
              {static_cast<const std::byte*>(mapping.m_startAddress), mapping.m_size},
              &writable.m_memoryManager.value().get()};
  for (const std::span<const std::byte> segment : {management(), samples_.memory})
    madvise(const_cast<std::byte*>(segment.data()), segment.size(), MADV_DONTDUMP);
  return true;
}

std::span<const std::byte> HostMemory::management() const {
  return {static_cast<const std::byte*>(*management_.baseAddress()), management_.size()};
}

std::uint64_t HostMemory::port_pool_offset() const {
  return static_cast<std::uint64_t>(reinterpret_cast<const std::byte*>(*ports_.portPool()) -
                                    management().data());
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
  return &management_;
}

iox::cxx::optional<iox::roudi::PortPool*> HostMemory::portPool() noexcept {
  if (!port_pool_.has_value()) return iox::cxx::nullopt;
  return iox::cxx::make_optional<iox::roudi::PortPool*>(&port_pool_.value());
}

iox::cxx::optional<iox::mepoo::MemoryManager*> HostMemory::introspectionMemoryManager() const noexcept {
  return introspection_.memoryManager();
}

iox::cxx::optional<iox::mepoo::SegmentManager<>*> HostMemory::segmentManager() const noexcept {
  return sample_block_.manager();
}

}  // namespace sft::shm
