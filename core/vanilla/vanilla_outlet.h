// Hands the samples of one publisher to its DDS writer, on a thread of its own: sending to DDS readers,
// however slow they or the network are, takes no time of the publisher. A few small samples may wait, or one
// large one; the oldest are left out if more come. So a bounded number of samples is held.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <thread>
#include <vector>

#include "core/platform/thread.h"
#include "core/seam/vanilla_port.h"
#include "core/sync/lock_order.h"
#include "core/sync/mutex.h"

namespace sft::core {

class VanillaOutlet final : public VanillaPort {
 public:
  /// So many samples may wait, as long as they have no more bytes together. The latest one always may, and so
  /// may as many as the publisher retains.
  static constexpr std::size_t waiting_max = 16, waiting_bytes_max = 256 << 10;

  /// Called on the thread of the outlet; false: the sample was refused.
  using Write = std::function<bool(const SampleHandle&)>;

  /// `retained_max`: how many samples the publisher retains.
  VanillaOutlet(Write write, std::size_t retained_max);
  ~VanillaOutlet() override { close(); }

  /// Begins to send. After begin_with(), once, unless it fails.
  Result<void> start(const ThreadSpec& thread);
  bool is_started() const { return thread_.joinable(); }
  /// Ends the thread, and lets go of all samples and of what writes them. What comes by send() later is
  /// dropped.
  void close();

  void show_readers(std::size_t readers) { readers_.store(readers, std::memory_order_relaxed); }

  void send(const SampleHandle& sample) noexcept override;
  void begin_with(std::vector<SampleHandle> retained) override { retained_ = std::move(retained); }
  std::size_t readers() const noexcept override { return readers_.load(std::memory_order_relaxed); }

  /// Samples that were left out, and those that were refused.
  std::uint64_t left_out() const { return left_out_.load(std::memory_order_relaxed); }

 private:
  bool put(const SampleHandle& sample, SampleHandle& oldest) noexcept SFT_REQUIRES(mutex_);
  SampleHandle take_oldest() noexcept SFT_REQUIRES(mutex_);
  bool is_closed();
  void run();

  Write write_;
  const std::size_t retained_max_;
  std::thread thread_;
  std::vector<SampleHandle> retained_;  ///< the thread's, once it runs
  std::atomic<std::size_t> readers_{0};
  std::atomic<std::uint64_t> left_out_{0};

  Mutex mutex_ SFT_ACQUIRED_AFTER(lock_order::endpoint) SFT_ACQUIRED_BEFORE(lock_order::facts);
  Condition arrived_;
  std::vector<SampleHandle> waiting_ SFT_GUARDED_BY(mutex_);  ///< a ring
  std::size_t first_ SFT_GUARDED_BY(mutex_) = 0, count_ SFT_GUARDED_BY(mutex_) = 0;
  std::size_t bytes_ SFT_GUARDED_BY(mutex_) = 0;  ///< of those that wait
  bool closed_ SFT_GUARDED_BY(mutex_) = false;
};

}  // namespace sft::core
