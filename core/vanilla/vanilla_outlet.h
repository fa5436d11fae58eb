// Passes the samples of one publisher to its DDS writer, on a separate thread. So a slow DDS reader or a
// slow network does not delay the publisher. A few small samples may wait, or one large sample. If more
// samples arrive, the oldest waiting samples are dropped, so that the number of samples in use is limited.
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
  /// The maximum number of waiting samples, and their maximum size together. The latest sample may always
  /// wait, and so may as many samples as the publisher retains.
  static constexpr std::size_t waiting_max = 16, waiting_bytes_max = 256 << 10;

  /// Called on the thread of the outlet. Returns false if the sample was refused.
  using Write = std::function<bool(const SampleHandle&)>;

  /// `retained_max` is the number of samples that the publisher retains.
  VanillaOutlet(Write write, std::size_t retained_max);
  ~VanillaOutlet() override { close(); }

  /// Begins to send. Must be called after begin_with(), and only once, unless the call fails.
  Result<void> start(const ThreadSpec& thread);
  bool is_started() const { return thread_.joinable(); }
  /// Ends the thread, and releases all samples and the function that writes them. Samples that send() gets
  /// later are dropped.
  void close();

  void show_readers(std::size_t readers) { readers_.store(readers, std::memory_order_relaxed); }

  void send(const SampleHandle& sample) noexcept override;
  void begin_with(std::vector<SampleHandle> retained) override { retained_ = std::move(retained); }
  std::size_t readers() const noexcept override { return readers_.load(std::memory_order_relaxed); }

  /// Returns the number of samples that were dropped or refused.
  std::uint64_t left_out() const { return left_out_.load(std::memory_order_relaxed); }

 private:
  bool put(const SampleHandle& sample, SampleHandle& oldest) noexcept SFT_REQUIRES(mutex_);
  SampleHandle take_oldest() noexcept SFT_REQUIRES(mutex_);
  bool is_closed();
  void run();

  Write write_;
  const std::size_t retained_max_;
  std::thread thread_;
  std::vector<SampleHandle> retained_;  ///< used only by the thread while it runs
  std::atomic<std::size_t> readers_{0};
  std::atomic<std::uint64_t> left_out_{0};

  Mutex mutex_ SFT_ACQUIRED_AFTER(lock_order::endpoint) SFT_ACQUIRED_BEFORE(lock_order::facts);
  Condition arrived_;
  std::vector<SampleHandle> waiting_ SFT_GUARDED_BY(mutex_);  ///< a ring buffer
  std::size_t first_ SFT_GUARDED_BY(mutex_) = 0, count_ SFT_GUARDED_BY(mutex_) = 0;
  std::size_t bytes_ SFT_GUARDED_BY(mutex_) = 0;  ///< the bytes of the waiting samples
  bool closed_ SFT_GUARDED_BY(mutex_) = false;
};

}  // namespace sft::core
