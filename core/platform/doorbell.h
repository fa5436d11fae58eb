// Waking a sleeping reader, in this process or another: a word in a page that the reader's process shares
// through /dev/shm. Ringing costs one atomic addition while the reader is awake, and one futex call when it
// sleeps; whoever rings several may do the first at once and leave the second to another thread.
//
// A page is a file `/dev/shm/sft_bell_<id in hex>`, locked (flock) by its owner as long as the process lives;
// whoever finds one unlocked may remove it, so that killed processes leave nothing for long.
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

/// One word to wait on. Lives in shared memory: no pointers, fixed layout.
struct alignas(64) Doorbell {
  std::atomic<std::uint32_t> rings{0};
  std::atomic<std::uint32_t> sleepers{0};

  // Any thread or process, after it made data visible.

  /// Wakes all who sleep.
  void ring() noexcept {
    if (announce()) wake();
  }
  /// The first half of ring(): whoever is awake knows. True if somebody sleeps: then wake() has to follow.
  [[nodiscard]] bool announce() noexcept {
    rings.fetch_add(1, std::memory_order_seq_cst);
    return has_sleepers();
  }
  void wake() noexcept;
  bool has_sleepers() const noexcept { return sleepers.load(std::memory_order_seq_cst) != 0; }

  /// Since `rings` was `seen`.
  bool rung(std::uint32_t seen) const noexcept { return rings.load(std::memory_order_seq_cst) != seen; }

  /// Keeps the core busy until the doorbell was rung since `rings` was `seen`, or the time is over; tells
  /// which. Lets others run that wait for this core.
  bool spin(std::uint32_t seen, std::chrono::steady_clock::time_point until) const noexcept;

  /// Sleeps until `ready()` holds, the doorbell was rung, or the deadline passed. Spurious returns are
  /// possible.
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

  /// A page of this process under a random id. Where /dev/shm cannot be used, because it is full for example,
  /// the page has no path, and processes of this account find it as one of nameless_pages(). Where that fails
  /// too, it is private memory with id 0: local readers work, and no other process can ring.
  static std::unique_ptr<DoorbellPage> create();
  /// A page of another process (or of this one), to ring. Only one of these accounts: whoever owns a page can
  /// make it shorter, which would end whoever rings in it.
  static Result<std::unique_ptr<DoorbellPage>> open(std::uint64_t id, const TrustedAccounts& accounts = {});
  /// A page may have had no path from the beginning, or somebody may have removed it: a clean-up script, or a
  /// service manager at log-out. Those of processes of this account are found among what these have open:
  /// links to open them by. Looks through all processes, which takes milliseconds.
  static std::map<std::uint64_t, std::string> nameless_pages();
  static Result<std::unique_ptr<DoorbellPage>> open_nameless(std::uint64_t id, const std::string& link);
  /// Returns the path of the page with that id.
  static std::string path_of(std::uint64_t id);
  /// Removes the pages of processes that are gone; returns how many.
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
  int fd_;  ///< holds the lock of a page that this process owns; -1 otherwise
};

}  // namespace sft::core
