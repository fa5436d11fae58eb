// Automatic requirement recording (ARR): which leaves a subscriber's getters read, folded sample by sample
// into what it asks its publishers for. Widening is immediate; narrowing waits until a leaf was not read for
// a number of samples.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "sft/options.h"
#include "sft/typesupport/access_log.h"
#include "sft/typesupport/field_mask.h"

namespace sft::core {

class Recorder;

/// The accesses of one sample that is being read. Belongs to its recorder, which lives as long as any is out.
class RecordedSample {
 public:
  RecordedSample(std::size_t words, AccessLog::MissListener* listener)
      : words_(words), log_(words_, listener) {}
  AccessLog& log() { return log_; }

 private:
  friend class Recorder;
  std::vector<std::atomic<std::uint64_t>> words_;
  AccessLog log_;
  std::shared_ptr<Recorder> recorder_;
};

class Recorder final : public std::enable_shared_from_this<Recorder>, private AccessLog::MissListener {
 public:
  /// Told that required() has changed; on the thread of a getter or of whoever released a sample, and under
  /// the recorder's lock: it posts, and returns.
  using Changed = std::function<void()>;

  static std::shared_ptr<Recorder> make(std::size_t leaves, const RecordingSettings& settings,
                                        Changed changed);

  /// From here on nobody is told any more. Samples may outlive whoever was.
  void detach();

  RecordedSample* begin();
  /// Folds the accesses of a sample, on any thread.
  static void end(RecordedSample* sample) noexcept;

  /// The leaves that are needed, as far as is known: all of them until the first samples were read.
  FieldMask required() const;
  /// Samples in which each leaf was read.
  std::vector<std::uint64_t> counts() const;

 private:
  Recorder(std::size_t leaves, const RecordingSettings& settings, Changed changed);
  void missed(std::size_t leaf) noexcept override;
  void fold(RecordedSample& sample) noexcept;
  bool refresh_required();

  const RecordingSettings settings_;

  mutable std::mutex mutex_;  // held for a few instructions
  Changed changed_;           ///< empty once detached
  FieldMask required_;
  std::uint64_t samples_ = 0;
  std::vector<std::uint64_t> last_read_;  // per leaf: number of the sample, from 1; 0 = never
  std::vector<std::uint64_t> counts_;
  std::vector<std::unique_ptr<RecordedSample>> owned_;
  std::vector<RecordedSample*> free_;
};

}  // namespace sft::core
