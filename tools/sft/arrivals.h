// A topic that is subscribed to in order to measure it.
#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <string>

#include "tools/sft/series.h"
#include "tools/sft/session.h"

namespace sft::tool {

/// Counts what comes, on threads of the node.
class Arrivals {
 public:
  /// What is to be noted of a sample, besides when it came.
  using Measure = std::function<double(const DynamicSample&)>;

  struct Request {
    std::string fields;
    SubscriberOptions options{};
    Measure measure{};
  };
  static Result<std::unique_ptr<Arrivals>> open(const FoundTopic& topic, Request request, Node& node);

  struct Report {
    double rate_hz = 0;
    Spread periods;             ///< in seconds
    Spread values;              ///< what was measured
    std::uint64_t samples = 0;  ///< since the beginning
    std::uint64_t lost = 0;     ///< likewise
    std::uint64_t fresh = 0;    ///< since the last report
  };
  /// Of so many seconds. With `lost` as the subscriber knows it.
  Report report(double window_s);

  const std::string& topic() const { return topic_; }

 private:
  Arrivals(std::string topic, Measure measure) : topic_(std::move(topic)), measure_(std::move(measure)) {}
  void note(const DynamicSample& sample);

  const std::string topic_;
  const Measure measure_;
  std::mutex mutex_;
  Periods periods_;
  Series values_;
  std::uint64_t samples_ = 0;
  std::uint64_t told_ = 0;
  std::optional<DynamicSubscriber> subscriber_;  // goes first: it calls back
};

}  // namespace sft::tool
