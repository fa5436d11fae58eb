// The part of the management segment that describes the segment of samples. iceoryx would make the file of
// that segment itself, and write zeros to all of it. This block takes a file that was made before.
#pragma once

#include <iceoryx_posh/internal/roudi/memory/mempool_segment_manager_memory_block.hpp>

#include "shm_transport/host/iceoryx.h"

namespace sft::shm {

class SampleBlock final : public iox::roudi::MemPoolSegmentManagerMemoryBlock {
 public:
  /// `config` must have one segment. When the memory becomes available, the file of the segment must exist,
  /// and have the size that SampleBlock::file_bytes() returns.
  explicit SampleBlock(const iox::mepoo::SegmentConfig& config);
  ~SampleBlock() override;

  static std::size_t file_bytes(const iox::mepoo::SegmentConfig& config);

  /// Returns the manager; nothing while the memory is not available.
  iox::cxx::optional<iox::mepoo::SegmentManager<>*> manager() const noexcept;

 private:
  class OpenedSegment;
  using Segment = iox::mepoo::MePooSegment<OpenedSegment, iox::mepoo::MemoryManager>;
  using Manager = iox::mepoo::SegmentManager<Segment>;

  void onMemoryAvailable(iox::cxx::not_null<void*> memory) noexcept override;
  void destroy() noexcept override;

  const iox::mepoo::SegmentConfig config_;
  Manager* manager_ = nullptr;
};

}  // namespace sft::shm
