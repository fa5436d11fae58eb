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
  /// A function that returns a value of a sample, or nothing if the sample has none. The value is recorded
  /// together with the time of arrival.
  using Measure = std::function<std::optional<double>(const DynamicSample&)>;

  struct Request {
    std::string fields;
    SubscriberOptions options{};
    Measure measure{};
  };
  static Result<std::unique_ptr<Arrivals>> open(const FoundTopic& topic, Request request, Node& node);

  struct Report {
    double rate_hz = 0;
    Spread periods;             ///< the times between samples, in seconds
    Spread values;              ///< the results of Request::measure
    std::uint64_t samples = 0;  ///< the number of samples since the beginning
    std::uint64_t lost = 0;     ///< the number of lost samples since the beginning, as counted by the
                                ///< subscriber
    std::uint64_t fresh = 0;    ///< the number of samples since the last report
  };
  /// Returns a report on the last `window_s` seconds.
  Report report(double window_s);

  const std::string& topic() const { return topic_; }

 private:
  Arrivals(std::string topic, Measure measure) : topic_(std::move(topic)), measure_(std::move(measure)) {}
  void note(const DynamicSample& sample);

  const std::string topic_;
  const Measure measure_;
  /// This class uses only public headers of SFT, and none of these contains the mutex class that Clang can
  /// check.
  std::mutex mutex_;  // guards the members below, but not the subscriber
  Periods periods_;
  Series values_;
  std::uint64_t samples_ = 0;
  std::uint64_t reported_ = 0;                   ///< samples_ at the last report
  std::optional<DynamicSubscriber> subscriber_;  ///< must be the last member, since its callbacks use the
                                                 ///< other members
};

}  // namespace sft::tool
