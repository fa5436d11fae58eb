// The shared memory of the daemon: iceoryx's management segment, and one segment with the pools of samples.
// The class does the same as IceOryxRouDiMemoryManager, but returns failures as values, creates the files
// quickly, and knows the position of the table of ports. From that table, readers learn whether they are
// connected.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "sft/result.h"
#include "shm_transport/host/iceoryx.h"
#include "shm_transport/sftd/groups.h"
#include "shm_transport/sftd/pools.h"
#include "shm_transport/sftd/sample_block.h"
#include "shm_transport/sftd/segment_file.h"

#include <iceoryx_hoofs/posix_wrapper/file_lock.hpp>
#include <iceoryx_posh/internal/roudi/memory/port_pool_memory_block.hpp>
#include <iceoryx_posh/roudi/memory/default_roudi_memory.hpp>
#include <iceoryx_posh/roudi/memory/roudi_memory_interface.hpp>
#include <iceoryx_posh/roudi/memory/roudi_memory_manager.hpp>
#include <iceoryx_posh/roudi/port_pool.hpp>

namespace sft::shm {

iox::RouDiConfig_t make_config(const PoolPlan& plan, const Groups& groups);

/// The data that programs need to map the segment of samples.
struct SampleSegment {
  std::uint64_t id = 0;
  std::span<const std::byte> memory;
  iox::mepoo::MemoryManager* pools = nullptr;
};

class HostMemory final : public iox::roudi::RouDiMemoryInterface {
 public:
  /// Returns the size of the management segment for these pools, in bytes.
  static std::size_t management_bytes(const iox::RouDiConfig_t& config);

  /// Creates the segments, whose files must not exist yet. Their memory is set aside in /dev/shm, except
  /// for the chunks on demand (Pool::on_demand). The files remain when the object is destroyed, and after a
  /// failure: OwnFiles removes them. Core dumps of this process leave the segments out.
  static Result<std::unique_ptr<HostMemory>> make(const PoolPlan& plan, const Groups& groups);

  const SampleSegment& samples() const { return samples_; }
  std::span<const std::byte> management() const;
  /// Returns the files of both segments. Must be called only once.
  std::vector<SegmentFile> take_files() { return std::exchange(files_, {}); }

  std::uint64_t port_pool_offset() const;

  iox::cxx::expected<iox::roudi::RouDiMemoryManagerError> createAndAnnounceMemory() noexcept override;
  iox::cxx::expected<iox::roudi::RouDiMemoryManagerError> destroyMemory() noexcept override;
  const iox::roudi::PosixShmMemoryProvider* mgmtMemoryProvider() const noexcept override;
  iox::cxx::optional<iox::roudi::PortPool*> portPool() noexcept override;
  iox::cxx::optional<iox::mepoo::MemoryManager*> introspectionMemoryManager() const noexcept override;
  iox::cxx::optional<iox::mepoo::SegmentManager<>*> segmentManager() const noexcept override;

 private:
  explicit HostMemory(const iox::RouDiConfig_t& config);
  std::array<iox::roudi::MemoryBlock*, 3> blocks();
  std::size_t management_file_bytes();
  bool find_samples(uid_t member);
  std::vector<FilePart> parts_on_demand(const PoolPlan& plan) const;

  iox::roudi::PortPoolMemoryBlock ports_;
  iox::cxx::optional<iox::roudi::PortPool> port_pool_;
  iox::roudi::MemPoolCollectionMemoryBlock introspection_;
  SampleBlock sample_block_;
  iox::roudi::PosixShmMemoryProvider management_;
  iox::roudi::RouDiMemoryManager manager_;
  SampleSegment samples_;
  std::vector<SegmentFile> files_;
};

}  // namespace sft::shm
