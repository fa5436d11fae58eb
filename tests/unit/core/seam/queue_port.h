// Reader ports whose take() returns the samples that the test has put into them.
#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>
#include <mutex>
#include <utility>

#include "tests/unit/core/seam/idle_ports.h"

namespace sft::core {

struct Queue {
  SampleHandle pop() {
    if (samples.empty()) return {};
    SampleHandle first = std::move(samples.front());
    samples.pop_front();
    return first;
  }

  bool is_connected = true;
  std::uint64_t unnoticed = 0;
  std::uint64_t discarded = 0;
  std::deque<SampleHandle> samples;
};

template <class Idle>
class QueueOf : public Idle, public Queue {
 public:
  SampleHandle take() noexcept override { return pop(); }
  bool connected(EndpointId) const noexcept override { return is_connected; }
  std::uint64_t arrivals(EndpointId) noexcept override { return samples.size(); }
  ReaderPort::Counters counters() const noexcept override {
    return {.discarded = discarded, .lost_unnoticed = unnoticed};
  }
};

using NetworkQueue = QueueOf<IdleNetworkReader>;

class MemoryQueue final : public QueueOf<IdleBorrowingReader> {
 public:
  SampleHandle take() noexcept override { return is_at_limit ? SampleHandle() : pop(); }
  bool some_wait() const noexcept override { return !samples.empty(); }
  SampleHandle take_of(EndpointId writer) noexcept override {
    const auto first = std::find_if(samples.begin(), samples.end(),
                                    [&](const SampleHandle& sample) { return sample->writer == writer; });
    if (first == samples.end()) return {};
    SampleHandle sample = std::move(*first);
    samples.erase(first);
    return sample;
  }

  void notify_room() noexcept override { ++told_of_room; }
  std::uint64_t held_too_many() const noexcept override { return at_limit; }

  std::uint64_t at_limit = 0;  ///< how often take() returned nothing because the limit was reached
  bool is_at_limit = false;    ///< true: the subscriber holds the maximum number of samples
  int told_of_room = 0;        ///< how often publishers that wait were told that samples were taken
};

/// A port to which one thread may add samples while another thread takes samples from it.
template <class Idle>
class SharedQueueOf final : public Idle {
 public:
  void put(SampleHandle sample) {
    const std::scoped_lock lock(mutex_);
    queue_.samples.push_back(std::move(sample));
  }
  SampleHandle take() noexcept override {
    const std::scoped_lock lock(mutex_);
    return queue_.pop();
  }

 private:
  std::mutex mutex_;
  Queue queue_;
};

using SharedMemoryQueue = SharedQueueOf<IdleBorrowingReader>;
using SharedNetworkQueue = SharedQueueOf<IdleNetworkReader>;

}  // namespace sft::core
