#include "tools/sft/publisher_counts.h"

#include <algorithm>
#include <utility>

#include "tools/sft/output.h"

namespace sft::tool {

PublisherCounts::PublisherCounts(std::string topic, const Session& session)
    : topic_(std::move(topic)), session_(session) {
  (void)report();
}

PublisherCounts::Report PublisherCounts::report() {
  const DomainSnapshot domain = session_.domain();
  const auto now = Traffic::Clock::now();
  traffic_.note(domain, now);
  Report report;
  for (const DomainSnapshot::Endpoint& publisher : domain.publishers) {
    if (publisher.topic != topic_ || !publisher.progress) continue;
    const std::uint64_t samples = publisher.progress->samples;
    const auto counted = counted_.try_emplace(publisher.id, samples).first;
    report.fresh += samples - std::min(counted->second, samples);
    counted->second = samples;
    const Traffic::Rate rate = traffic_.of(publisher.id, now).value_or(Traffic::Rate{});
    report.rate_hz += rate.samples_per_s;
    report.bytes_per_s += rate.bytes_per_s;
  }
  samples_ += report.fresh;
  report.samples = samples_;
  return report;
}

std::unique_ptr<PublisherCounts> counts_instead(const std::string& topic, const Error& error,
                                                const Session& session) {
  const auto name = session.undescribed(topic);
  if (!name) return nullptr;
  complain(error.message + "; what its publishers count is shown instead");
  return std::make_unique<PublisherCounts>(*name, session);
}

}  // namespace sft::tool
