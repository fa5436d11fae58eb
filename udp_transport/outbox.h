// What one writer has to send under one mask and could not send at once: a queue from the publisher's thread
// to the sending thread that keeps the newest.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

#include "core/sample_buffer.h"
#include "sft/typesupport/project.h"
#include "udp_transport/destination.h"
#include "udp_transport/fragmenter.h"

namespace sft::udp {

/// Who gets one encoding, and how it is called on the wire.
struct Audience {
  std::uint16_t variant = 0;
  std::uint64_t mask = 0;                 ///< as in the header
  std::vector<std::uint64_t> mask_words;  ///< empty where the header says it all
  std::vector<std::shared_ptr<Destination>> destinations;
};

/// One encoding of one sample, for the destinations that it has not been sent to yet.
struct Job {
  core::SampleHandle sample;  ///< keeps what the projection refers to
  Projection projection;
  FirstHeader first;
  std::shared_ptr<const Audience> audience;
  std::size_t next_destination = 0;

  EncodedBody body() const { return {first, audience->mask_words, projection.segments()}; }
};

/// Counts of one writer, over all its masks.
struct WriterTally {
  std::atomic<std::uint64_t> history_waiting{0};  ///< retained samples that have not been sent yet
  std::atomic<std::uint64_t> bytes_sent{0};
  std::atomic<std::uint64_t> dropped{0};  ///< samples that a destination did not get
};

class Outbox {
 public:
  Outbox(std::size_t depth, std::shared_ptr<WriterTally> tally);

  // The publisher's thread.

  /// The job to fill next. Its projection keeps its memory from use to use.
  Job& blank() { return *blank_; }
  /// Nothing is queued or being sent: what is sent now overtakes nothing.
  bool idle() const { return !busy_.load(std::memory_order_acquire); }

  struct Posted {
    bool was_idle;        ///< the sending thread has to be told of this outbox
    bool dropped_oldest;  ///< the queue was full
  };
  /// Queues the blank job.
  Posted post();

  // The agent's thread.

  /// From here on what is posted waits, until as many release().
  void hold();
  /// Queues retained samples, before all that waits. Whether the sending thread has to be told.
  [[nodiscard]] bool release(std::vector<std::unique_ptr<Job>> history);

  // The sending thread.

  /// The oldest job, until done(); null if there is none, which makes the outbox idle.
  Job* next();
  void done();
  WriterTally& tally() const { return *tally_; }

 private:
  void keep_spare(std::unique_ptr<Job> job);

  const std::size_t depth_;
  const std::shared_ptr<WriterTally> tally_;
  std::atomic<bool> busy_{false};  ///< scheduled_ or held_, as the publisher sees it
  std::unique_ptr<Job> blank_;     ///< the publisher's
  std::unique_ptr<Job> current_;   ///< the sending thread's
  std::mutex mutex_;
  bool scheduled_ = false;                     ///< the sending thread knows of it
  std::size_t held_ = 0;                       ///< by so many
  std::vector<std::unique_ptr<Job>> queue_;    ///< the oldest first
  std::vector<std::unique_ptr<Job>> history_;  ///< goes before that, in reverse order
  std::vector<std::unique_ptr<Job>> spare_;
};

}  // namespace sft::udp
