#include "tools/sft/arrivals.h"

#include <chrono>
#include <utility>

namespace sft::tool {

Result<std::unique_ptr<Arrivals>> Arrivals::open(const FoundTopic& topic, Request request, Node& node) {
  std::unique_ptr<Arrivals> arrivals(new Arrivals(topic.name, std::move(request.measure)));
  Arrivals* const self = arrivals.get();
  auto subscriber = node.subscriber(topic.name, topic.type, request.fields, request.options,
                                    [self](const DynamicSample& sample) { self->note(sample); });
  if (!subscriber) return tl::unexpected(subscriber.error());
  arrivals->subscriber_ = std::move(*subscriber);
  return arrivals;
}

void Arrivals::note(const DynamicSample& sample) {
  const std::optional<double> value = measure_ ? measure_(sample) : 0;
  const std::scoped_lock lock(mutex_);
  const Moment when = std::chrono::steady_clock::now();
  periods_.add(when);
  if (value) values_.add(when, *value);
  ++samples_;
}

Arrivals::Report Arrivals::report(double window_s) {
  const std::uint64_t lost = subscriber_->status().lost;
  const std::scoped_lock lock(mutex_);
  const Moment begin = std::chrono::steady_clock::now() - seconds(window_s);
  periods_.forget_before(begin);
  values_.forget_before(begin);
  return {.rate_hz = periods_.rate(),
          .periods = periods_.spread(),
          .values = values_.spread(),
          .samples = samples_,
          .lost = lost,
          .fresh = samples_ - std::exchange(reported_, samples_)};
}

}  // namespace sft::tool
