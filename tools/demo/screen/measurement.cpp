#include "tools/demo/screen/measurement.h"

#include <algorithm>

namespace sft::demo {

namespace {

double wire_bytes(const Traffic& begin, const Traffic& end) {
  return std::max(0.0, static_cast<double>((end - begin).data_received()));
}

/// Bytes per sample are those of the steady state. Where fields are recorded, these are the bytes after the
/// mask had narrowed.
void add_bytes(const SubscriberReport& begin, const SubscriberReport& now, const Conditions& conditions,
               SubscriberFigures& figures) {
  const LearningReport steady =
      now.learning.value_or(LearningReport{begin.received, begin.payload_bytes, begin.traffic});
  figures.payload_bytes = static_cast<double>(now.payload_bytes - begin.payload_bytes);
  if (conditions.metered) {
    const bool still_learns = conditions.recorded && !now.learning && !figures.in_shared_memory();
    const Traffic& learnt = still_learns ? now.traffic : steady.traffic;
    figures.learning_bytes = static_cast<double>((learnt - begin.traffic).data_received());
    figures.wire_bytes = wire_bytes(begin.traffic, now.traffic);
  }
  if (now.received <= steady.received) return;
  const auto samples = static_cast<double>(now.received - steady.received);
  figures.payload_bytes_per_sample = static_cast<double>(now.payload_bytes - steady.payload_bytes) / samples;
  if (conditions.metered) figures.wire_bytes_per_sample = wire_bytes(steady.traffic, now.traffic) / samples;
}

}  // namespace

SubscriberFigures measure(const SubscriberReport& begin, const SubscriberReport& now, std::uint64_t published,
                          const Conditions& conditions) {
  SubscriberFigures figures;
  static_cast<Reception&>(figures) = now;
  figures.recorded = conditions.recorded;
  figures.withheld = conditions.withheld;
  // A subscriber cannot know about samples after the last one that it received.
  const std::uint64_t missing = published - std::min(published, now.received + figures.withheld);
  figures.lost = conditions.is_over ? std::max(missing, now.lost) : now.lost;
  add_bytes(begin, now, conditions, figures);
  return figures;
}

}  // namespace sft::demo
