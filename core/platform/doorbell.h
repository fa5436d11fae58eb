// A doorbell wakes a sleeping reader, in this process or in another one. The doorbell is a word in a page
// that the reader's process shares through /dev/shm. Ringing costs one atomic addition if the reader is
// awake, and in addition a futex call if it sleeps. A thread that rings several doorbells may do the
// additions itself, and leave the futex calls to another thread.
//
// A page is a file `/dev/shm/sft_bell_<id in hex>`. The process that owns the page locks the file (flock)
// as long as it lives. Any process may remove a page that is not locked, so that pages of killed processes
// do not stay for long.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "core/platform/trusted_file.h"
#include "sft/result.h"

namespace sft::core {

/// One word on which threads wait. It lies in shared memory, so it has no pointers, and a fixed layout.
struct alignas(64) Doorbell {
  std::atomic<std::uint32_t> rings{0};
  std::atomic<std::uint32_t> sleepers{0};

  // The following functions are called by any thread or process, after that thread or process has made data
  // visible.

  /// Wakes all sleeping threads.
  void ring() noexcept {
    if (announce()) wake();
  }
  /// Does the first half of ring(), which is enough for threads that are awake. If it returns true, a
  /// thread sleeps at this doorbell, and the caller must call wake().
  [[nodiscard]] bool announce() noexcept {
    rings.fetch_add(1, std::memory_order_seq_cst);
    return has_sleepers();
  }
  void wake() noexcept;
  bool has_sleepers() const noexcept { return sleepers.load(std::memory_order_seq_cst) != 0; }

  /// Returns true if the doorbell was rung since `rings` had the value `seen`.
  bool rung(std::uint32_t seen) const noexcept { return rings.load(std::memory_order_seq_cst) != seen; }

  /// Keeps the core busy until the doorbell has been rung since `rings` had the value `seen`, and then
  /// returns true. Returns false if the doorbell was not rung by then. Lets other threads that wait for
  /// this core run meanwhile.
  bool spin(std::uint32_t seen, std::chrono::steady_clock::time_point until) const noexcept;

  /// Sleeps until the doorbell is rung or the deadline has passed. Does not sleep if `ready()` returns true.
  /// Spurious returns are possible.
  template <class Ready>
  void wait(std::chrono::steady_clock::time_point deadline, Ready&& ready) noexcept {
    const std::uint32_t seen = rings.load(std::memory_order_seq_cst);
    sleepers.fetch_add(1, std::memory_order_seq_cst);
    if (!ready()) sleep(seen, deadline);
    sleepers.fetch_sub(1, std::memory_order_seq_cst);
  }

 private:
  void sleep(std::uint32_t seen, std::chrono::steady_clock::time_point deadline) noexcept;
};

class DoorbellPage {
 public:
  static constexpr std::uint32_t slots = 1024;

  /// Creates a page of this process with a random id. If /dev/shm cannot be used, for example because it is
  /// full, the page has no path, and processes of this account find it by nameless_pages(). If a page
  /// without a path cannot be created either, the page is private memory with id 0. Then doorbells work
  /// within this process, but no other process can ring them.
  static std::unique_ptr<DoorbellPage> create();
  /// Opens a page of any process, to ring its doorbells. The page must belong to one of `accounts`. The
  /// owner of the file can truncate it, which would crash a process that rings a doorbell in it.
  static Result<std::unique_ptr<DoorbellPage>> open(std::uint64_t id, const TrustedAccounts& accounts = {});
  /// Returns the pages without a path of all processes of this account: for each id a link by which the
  /// page can be opened. Such a page never had a path, or the path was removed, by a clean-up script or by
  /// a service manager at log-out. The function searches the open files of all processes, which takes
  /// milliseconds.
  static std::map<std::uint64_t, std::string> nameless_pages();
  static Result<std::unique_ptr<DoorbellPage>> open_nameless(std::uint64_t id, const std::string& link);
  /// Returns the path of the page with that id.
  static std::string path_of(std::uint64_t id);
  /// Removes the pages of processes that have ended. Returns the number of removed pages.
  static std::size_t sweep() noexcept;

  ~DoorbellPage();
  DoorbellPage(const DoorbellPage&) = delete;
  DoorbellPage& operator=(const DoorbellPage&) = delete;

  std::uint64_t id() const { return id_; }
  Doorbell& at(std::uint32_t slot) { return bells_[slot]; }

 private:
  static Result<std::unique_ptr<DoorbellPage>> share(std::uint64_t id, const FileDescriptor& file);
  DoorbellPage(std::uint64_t id, Doorbell* bells, int fd) : id_(id), bells_(bells), fd_(fd) {}

  std::uint64_t id_;
  Doorbell* bells_;
  int fd_;  ///< a descriptor whose lock marks the page as owned by this process; -1 for pages of other
            ///< processes
};

}  // namespace sft::core
