// Readers' ports that hand out what the test put into them.
#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>
#include <mutex>
#include <utility>
#include <vector>

#include "core/seam/transport.h"

namespace sft::core {

class QueuePort final : public ReaderPort {
 public:
  SampleHandle take() noexcept override {
    if (samples.empty()) return {};
    SampleHandle first = std::move(samples.front());
    samples.pop_front();
    return first;
  }
  SampleHandle take_of(EndpointId writer) noexcept override {
    const auto first = std::find_if(samples.begin(), samples.end(),
                                    [&](const SampleHandle& sample) { return sample->writer == writer; });
    if (first == samples.end()) return {};
    SampleHandle sample = std::move(*first);
    samples.erase(first);
    return sample;
  }
  Result<void> connect(const Source&) override { return {}; }
  bool connected(EndpointId) const noexcept override { return is_connected; }
  std::uint64_t arrivals(EndpointId) noexcept override { return samples.size(); }
  void disconnect(EndpointId) noexcept override {}
  void accept(std::vector<Accepted>) override {}
  std::uint64_t discarded() const noexcept override { return 0; }
  std::uint64_t lost_unnoticed() const noexcept override { return unnoticed; }

  bool is_connected = true;
  std::uint64_t unnoticed = 0;
  std::deque<SampleHandle> samples;
};

/// A port that another thread fills.
class SharedPort final : public ReaderPort {
 public:
  void put(SampleHandle sample) {
    const std::scoped_lock lock(mutex_);
    queue_.samples.push_back(std::move(sample));
  }
  SampleHandle take() noexcept override {
    const std::scoped_lock lock(mutex_);
    return queue_.take();
  }
  Result<void> connect(const Source&) override { return {}; }
  bool connected(EndpointId) const noexcept override { return true; }
  std::uint64_t arrivals(EndpointId) noexcept override { return 0; }
  void disconnect(EndpointId) noexcept override {}
  void accept(std::vector<Accepted>) override {}
  std::uint64_t discarded() const noexcept override { return 0; }

 private:
  std::mutex mutex_;
  QueuePort queue_;
};

}  // namespace sft::core
