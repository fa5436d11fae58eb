#include "shm_transport/sftd/page_clearer.h"

#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <tuple>
#include <utility>

#include "core/platform/thread.h"

namespace sft::shm {

namespace {

/// The nice value of the thread: a tenth of the processor time of others, if these leave none.
constexpr int gives_way = 10;
/// The mappings of the process are locked for so much at a time: other threads of the daemon may wait.
constexpr std::size_t cleared_in_a_call = std::size_t{128} << 10;

/// False if the system refuses it: before Linux 5.14.
bool clear_pages(std::span<const std::byte> pages) {
  return ::madvise(const_cast<std::byte*>(pages.data()), pages.size(), MADV_POPULATE_WRITE) == 0;
}

}  // namespace

Result<void> PageClearer::start(std::vector<std::span<const std::byte>> memory) {
  auto thread = core::start_thread("sftd-clearer", [this, memory = std::move(memory)] { clear(memory); });
  if (!thread) return tl::unexpected(thread.error());
  thread_ = std::move(*thread);
  return {};
}

PageClearer::~PageClearer() {
  stops_.store(true, std::memory_order_relaxed);
  if (thread_.joinable()) thread_.join();
}

void PageClearer::clear(const std::vector<std::span<const std::byte>>& memory) {
  std::ignore = ::setpriority(PRIO_PROCESS, static_cast<id_t>(::gettid()), gives_way);
  for (std::span<const std::byte> rest : memory) {
    while (!rest.empty() && !stops_.load(std::memory_order_relaxed)) {
      const std::size_t bytes = std::min(rest.size(), cleared_in_a_call);
      if (!clear_pages(rest.first(bytes))) return;
      rest = rest.subspan(bytes);
    }
  }
}

}  // namespace sft::shm
