// One encoding of one sample, which is shared by all lanes that still have to send it.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "core/platform/clock.h"
#include "core/seam/sample_buffer.h"
#include "core/sync/lock_order.h"
#include "core/sync/mutex.h"
#include "sft/detail/project.h"
#include "udp_transport/outgoing/kept_memory.h"
#include "udp_transport/wire/fragmenter.h"

namespace sft::udp {

class JobPool;

/// The values by which datagrams name one of a writer's masks.
struct WireMask {
  /// The maximum number of words of a mask on the wire. More words would fill most of the shortest first
  /// datagram, so a longer mask is named by its hash alone.
  static constexpr std::size_t words_max = 32;

  std::uint16_t variant = 0;
  std::uint64_t mask = 0;            ///< value of the mask field of the header
  std::vector<std::uint64_t> words;  ///< the words of the mask; empty if `mask` alone identifies the mask
};

/// Longer bodies are sent by the sending thread, so that the publisher continues after a few datagrams. The
/// exception is a body that would have to be copied for that. The publisher's thread sends such a body
/// itself.
inline constexpr std::size_t direct_bytes_max = 16 * 1024;

/// The publisher's thread must write to a job only while no lane has it.
///
/// A job may also be a pack: copies of several small samples with the same mask, the same stamp and
/// consecutive sequences. In a pack, `first` is the header of the first sample, except that its total is
/// that of all samples.
struct Job {
  core::SampleHandle sample;  ///< the sample, which keeps the memory that the projection refers to
  detail::Projection projection;
  FirstHeader first;
  std::shared_ptr<const WireMask> mask;
  std::uint64_t sequence = 0;  ///< the whole sequence, not only its low bits
  /// The size in bytes of the sample's body with all fields; in a pack, the sum of these sizes.
  std::uint32_t whole_bytes = 0;
  /// The number of bytes of the body that were sent already. The lane that gets the job sends the rest.
  std::uint32_t sent_bytes = 0;

  EncodedBody body() const { return body(first); }
  /// Returns the body with the given header.
  EncodedBody body(const FirstHeader& header) const {
    if (is_pack()) return {header, mask->words, packed_, true};
    return {header, mask->words, copied_.data == nullptr ? projection.segments() : std::span(&copied_, 1)};
  }
  /// Returns the body of `samples` samples of a pack, beginning with the sample `part`. A single sample is
  /// returned as a normal body, not as a pack.
  EncodedBody body(const FirstHeader& header, std::size_t part, std::size_t samples) const {
    if (!is_pack()) return body(header);
    return {header, mask->words, std::span(packed_).subspan(part, samples), samples > 1};
  }

  bool is_pack() const { return !packed_.empty(); }
  /// Returns true if the body is so small (`direct_bytes_max`) that the publisher's thread sends it itself,
  /// if the window allows that.
  bool is_small() const { return is_pack() || first.total <= direct_bytes_max; }
  std::size_t samples() const { return is_pack() ? packed_.size() : 1; }
  /// Returns the length in bytes of the body of the sample `part`.
  std::uint32_t body_bytes(std::size_t part) const {
    return is_pack() ? static_cast<std::uint32_t>(packed_[part].bytes) : first.total;
  }

  /// Returns the share of `whole_bytes` that counts for the sample `part` of a pack. The samples of a pack
  /// have equal shares, except for one byte, so that all shares add up to the whole.
  std::uint32_t whole_bytes_of(std::size_t part) const {
    const auto before = [&](std::size_t shares) {
      return static_cast<std::uint32_t>(std::uint64_t{whole_bytes} * shares / samples());
    };
    return before(part + 1) - before(part);
  }

  /// Makes the job independent of the sample that it was encoded from.
  void copy_body();
  /// Copies the body into memory of the caller, which must be at least as large as the body.
  void copy_body(core::SampleHandle to);
  /// Counts the job's sample as borrowed memory (JobPool::may_borrow()), which is limited.
  void borrow();
  /// Counts the job's memory as kept (KeptMemory) until its last handle is destroyed. Must be called only by
  /// the thread that gives the job to channels.
  void keep();
  /// Adds a sample to a pack, or begins a pack. After seal(), the pack can be sent, and no sample can be
  /// added.
  void pack(std::span<const detail::Segment> body);
  void pack(std::span<const std::byte> body) {
    const detail::Segment whole{body.data(), body.size()};
    pack(std::span(&whole, 1));
  }
  void seal();
  std::size_t packed_bytes() const { return packed_bytes_; }
  /// Returns the size in bytes of the memory that the sample, or the sample `part` of a pack, occupies.
  std::size_t held_bytes(std::size_t part = 0) const {
    if (is_pack()) return packed_[part].bytes;
    return sample ? sample->capacity : copy_.size();
  }
  std::size_t held_bytes_in_all() const { return is_pack() ? packed_bytes_ : held_bytes(); }

 private:
  friend class JobHandle;
  friend class JobPool;
  std::vector<std::byte> copy_;  ///< copy of the body, or of a pack's bodies; empty if there is no copy
  detail::Segment copied_{};     ///< the copied body, in `copy_` or in memory of the caller
  std::size_t borrowed_bytes_ = 0;
  std::size_t kept_bytes_ = 0;
  std::vector<detail::Segment>
      packed_;  ///< the bodies of a pack in `copy_`; only their lengths are set until seal()
  std::size_t packed_bytes_ = 0;
  std::shared_ptr<JobPool> pool_;  ///< the job's pool, while the job is in use
  std::atomic<std::uint32_t> references_{0};
};

/// A handle of a job. Several handles may share one job. When the last handle is destroyed, the job releases
/// its sample and returns to its pool.
class JobHandle {
 public:
  JobHandle() = default;
  JobHandle(const JobHandle& other) : job_(other.job_) {
    if (job_ != nullptr) job_->references_.fetch_add(1, std::memory_order_relaxed);
  }
  JobHandle(JobHandle&& other) noexcept : job_(std::exchange(other.job_, nullptr)) {}
  JobHandle& operator=(JobHandle other) noexcept {
    std::swap(job_, other.job_);
    return *this;
  }
  ~JobHandle();

  explicit operator bool() const { return job_ != nullptr; }
  Job* operator->() const { return job_; }
  Job& operator*() const { return *job_; }

 private:
  friend class JobPool;
  explicit JobHandle(Job* job) : job_(job) { job->references_.store(1, std::memory_order_relaxed); }
  Job* job_ = nullptr;
};

/// The jobs of one writer. Spare jobs keep the memory of their projections. Any thread may call the
/// functions.
class JobPool : public std::enable_shared_from_this<JobPool> {
 public:
  /// `memory` counts the bytes that channels keep.
  static std::shared_ptr<JobPool> make(std::shared_ptr<KeptMemory> memory = std::make_shared<KeptMemory>()) {
    return std::shared_ptr<JobPool>(new JobPool(std::move(memory)));
  }

  /// Returns a job without a sample.
  JobHandle take();

  /// Destroys spare jobs that were not used during the whole last period of the node's pool. Must be called
  /// now and then, by a thread for which no other thread waits.
  void give_back(core::Time now);

  bool has_borrowed() const { return borrowed_samples_.load(std::memory_order_relaxed) > 0; }
  /// Returns true if one more sample with `bytes` bytes of borrowed memory may be held.
  bool may_borrow(std::size_t bytes) const {
    const std::size_t samples = borrowed_samples_.load(std::memory_order_relaxed);
    const std::size_t in_all = borrowed_bytes_.load(std::memory_order_relaxed) + bytes;
    return samples == 0 || (samples < borrowed_samples_max && in_all <= borrowed_bytes_max);
  }

 private:
  friend class JobHandle;
  friend struct Job;
  explicit JobPool(std::shared_ptr<KeptMemory> memory) : memory_(std::move(memory)) {}
  void recycle(std::unique_ptr<Job> job) noexcept;
  void widen(Job& job) noexcept SFT_REQUIRES(mutex_);

  /// The maximum number of spare jobs. It suffices for many masks with a few samples each, or for all
  /// samples that a process acknowledges at a time.
  static constexpr std::size_t spare_max = 2048;
  /// Limits the memory of projections in all jobs together. Within this limit, each spare job has memory
  /// for the largest projection that any job needed.
  static constexpr std::size_t projections_bytes_max = std::size_t{4} << 20;
  /// The maximum size in bytes of a copy whose memory is kept for the next job.
  static constexpr std::size_t spare_copy_bytes_max = 64 * 1024;
  /// The maximum number of borrowed samples. It suffices for the samples that are under way to readers that
  /// keep up, and for a few more. Other publishers on this host need the rest of the memory.
  static constexpr std::size_t borrowed_samples_max = 8;
  static constexpr std::size_t borrowed_bytes_max = std::size_t{24} << 20;
  const std::shared_ptr<KeptMemory> memory_;
  std::atomic<std::size_t> borrowed_samples_{0}, borrowed_bytes_{0};
  core::Mutex mutex_ SFT_ACQUIRED_AFTER(core::lock_order::facts) SFT_ACQUIRED_BEFORE(core::lock_order::jobs);
  /// The spare jobs. The vector has capacity for all jobs of the pool.
  std::vector<std::unique_ptr<Job>> spare_ SFT_GUARDED_BY(mutex_);
  std::size_t jobs_ SFT_GUARDED_BY(mutex_) = 0;      ///< number of jobs that are in use or spare
  std::size_t unneeded_ SFT_GUARDED_BY(mutex_) = 0;  ///< minimum number of spare jobs in the present period
  core::Time period_ends_ SFT_GUARDED_BY(mutex_){};
  detail::Projection::Memory widest_ SFT_GUARDED_BY(mutex_);  ///< the largest memory that a returned job had
};

}  // namespace sft::udp
