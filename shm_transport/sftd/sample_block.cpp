#include "shm_transport/sftd/sample_block.h"

#include <new>
#include <utility>

namespace sft::shm {

/// A segment that opens an existing file. iceoryx's own class would create the file.
class SampleBlock::OpenedSegment final : public iox::posix::SharedMemoryObject {
 public:
  using Result = iox::cxx::expected<OpenedSegment, iox::posix::SharedMemoryObjectError>;

  static Result create(const iox::posix::SharedMemory::Name_t& name, std::uint64_t bytes,
                       iox::posix::AccessMode access, iox::posix::OpenMode, const void* address,
                       iox::cxx::perms permissions) noexcept {
    using iox::posix::OpenMode;
    auto opened =
        SharedMemoryObject::create(name, bytes, access, OpenMode::OPEN_EXISTING, address, permissions);
    if (opened.has_error()) return iox::cxx::error<iox::posix::SharedMemoryObjectError>(opened.get_error());
    return iox::cxx::success<OpenedSegment>(OpenedSegment(std::move(opened.value())));
  }

 private:
  explicit OpenedSegment(SharedMemoryObject&& opened) noexcept : SharedMemoryObject(std::move(opened)) {}
};

SampleBlock::SampleBlock(const iox::mepoo::SegmentConfig& config)
    : MemPoolSegmentManagerMemoryBlock(config), config_(config) {}

SampleBlock::~SampleBlock() { SampleBlock::destroy(); }

std::size_t SampleBlock::file_bytes(const iox::mepoo::SegmentConfig& config) {
  return Manager::requiredChunkMemorySize(config);
}

void SampleBlock::onMemoryAvailable(iox::cxx::not_null<void*> memory) noexcept {
  iox::posix::Allocator allocator(memory, size());
  manager_ = new (allocator.allocate(sizeof(Manager), alignof(Manager))) Manager(config_, &allocator);
}

void SampleBlock::destroy() noexcept {
  if (manager_ != nullptr) manager_->~Manager();
  manager_ = nullptr;
}

/// Casts the manager, because iceoryx only knows a manager of its own class of segments. Both classes have
/// the same members.
iox::cxx::optional<iox::mepoo::SegmentManager<>*> SampleBlock::manager() const noexcept {
  static_assert(sizeof(OpenedSegment) == sizeof(iox::posix::SharedMemoryObject));
  static_assert(sizeof(Segment) == sizeof(iox::mepoo::MePooSegment<>));
  static_assert(sizeof(Manager) == sizeof(iox::mepoo::SegmentManager<>));
  if (manager_ == nullptr) return iox::cxx::nullopt;
  return iox::cxx::make_optional<iox::mepoo::SegmentManager<>*>(
      reinterpret_cast<iox::mepoo::SegmentManager<>*>(manager_));
}

}  // namespace sft::shm
