#include "shm_transport/sftd/page_clearer.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cstddef>
#include <tuple>
#include <utility>

#include "core/platform/thread.h"

namespace sft::shm {

namespace {

/// The nice value of the thread. If other threads leave no processor idle, this thread gets a tenth of the
/// time that one of the other threads gets.
constexpr int gives_way = 10;
constexpr std::size_t cleared_in_a_call = std::size_t{1} << 20;

}  // namespace

Result<void> PageClearer::start(std::vector<SegmentFile> segments) {
  segments_ = std::move(segments);
  auto thread = core::start_thread("sftd-clearer", [this] { clear(); });
  if (!thread) return tl::unexpected(thread.error());
  thread_ = std::move(*thread);
  return {};
}

PageClearer::~PageClearer() {
  stops_.store(true, std::memory_order_relaxed);
  if (thread_.joinable()) thread_.join();
}

void PageClearer::clear() const {
  std::ignore = ::setpriority(PRIO_PROCESS, static_cast<id_t>(::gettid()), gives_way);
  for (const SegmentFile& segment : segments_) {
    for (const FilePart& part : segment.at_once()) {
      for (std::size_t done = 0; done < part.bytes && !stops_.load(std::memory_order_relaxed);) {
        const std::size_t bytes = std::min(part.bytes - done, cleared_in_a_call);
        if (!clear_pages(segment, part.offset + done, bytes)) return;
        done += bytes;
      }
    }
  }
}

}  // namespace sft::shm
