// The queue of the samples that have arrived for one reader of the fake transport, and the counts of
// displaced samples.
#pragma once

#include <cstdint>
#include <deque>
#include <mutex>
#include <vector>

#include "core/seam/transport.h"
#include "core/sync/guarded_call.h"

namespace sft::test {

/// Any thread may call any function. No lock is held while the listener is called.
class FakeInbox {
 public:
  explicit FakeInbox(const core::ReaderSpec& spec);

  /// Queues the sample. Returns false if the sample is not for this reader.
  bool put(core::SampleHandle sample);
  /// Calls the listener.
  void announce() noexcept { notify_listener_(); }
  /// After detach() returns, no thread calls the listener or is still in such a call. The listener may call
  /// detach() itself.
  void detach() noexcept { notify_listener_.clear(); }

  core::SampleHandle take();
  void connect(const core::Source& source);
  void disconnect(core::EndpointId writer);
  void accept(std::vector<core::Accepted> accepted);

  bool connected(core::EndpointId writer) const;
  core::HistoryProgress history(core::EndpointId writer) const;
  std::uint64_t arrivals(core::EndpointId writer) const;
  std::uint64_t discarded() const;
  std::uint64_t lost_unnoticed() const;

 private:
  struct Writer {
    core::EndpointId id;
    bool connected = true;
    bool history_first = false;  ///< whether the writer's history is still to come; see core::Source
    std::uint64_t newest = 0;    ///< the greatest sequence that has arrived
    std::uint64_t arrivals = 0;
    bool begun = false;         ///< whether a sample was taken, so that gaps show missing samples
    std::uint64_t dropped = 0;  ///< the number of samples dropped since the last sample that was taken
  };
  const Writer* find(core::EndpointId id) const;
  Writer* find(core::EndpointId id);
  bool wants(const core::SampleBuffer& sample) const;
  template <class Condition>
  void keep_newest(Condition is_counted, std::vector<core::SampleHandle>& surplus);
  void forget_the_finished();

  const core::EndpointId id_;
  const std::size_t depth_;
  core::GuardedCall<> notify_listener_;

  mutable std::mutex mutex_;  // guards the members below
  std::vector<core::Accepted> accepted_;
  std::vector<Writer> writers_;
  std::deque<core::SampleHandle> queue_;  ///< samples of all writers, in the order of arrival
  std::uint64_t discarded_ = 0;
  std::uint64_t lost_unnoticed_ = 0;
};

}  // namespace sft::test
