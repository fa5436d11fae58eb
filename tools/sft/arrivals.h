// A subscription that measures the samples of a topic.
#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <string>

#include "tools/sft/series.h"
#include "tools/sft/session.h"

namespace sft::tool {

/// Counts and measures samples as they arrive, on threads of the node.
class Arrivals {
 public:
  /// Returns the value of a sample, which is recorded beside its time of arrival; nothing if it has none.
  using Measure = std::function<std::optional<double>(const DynamicSample&)>;

  struct Request {
    std::string fields;
    SubscriberOptions options{};
    Measure measure{};
  };
  static Result<std::unique_ptr<Arrivals>> open(const FoundTopic& topic, Request request, Node& node);

  struct Report {
    double rate_hz = 0;
    Spread periods;             ///< in seconds
    Spread values;              ///< the results of Request::measure
    std::uint64_t samples = 0;  ///< since the beginning
    std::uint64_t lost = 0;     ///< since the beginning, as the subscriber counts
    std::uint64_t fresh = 0;    ///< since the last report
  };
  /// Reports the last `window_s` seconds.
  Report report(double window_s);

  const std::string& topic() const { return topic_; }

 private:
  Arrivals(std::string topic, Measure measure) : topic_(std::move(topic)), measure_(std::move(measure)) {}
  void note(const DynamicSample& sample);

  const std::string topic_;
  const Measure measure_;
  /// This class uses only public headers of SFT, and none of these has the mutex that Clang checks.
  std::mutex mutex_;  // guards the members below, but not the subscriber
  Periods periods_;
  Series values_;
  std::uint64_t samples_ = 0;
  std::uint64_t reported_ = 0;                   ///< samples_ at the last report
  std::optional<DynamicSubscriber> subscriber_;  ///< the last member: its callbacks use the others
};

}  // namespace sft::tool
