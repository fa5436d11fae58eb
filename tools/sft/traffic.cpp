#include "tools/sft/traffic.h"

#include <algorithm>

namespace sft::tool {

namespace {
constexpr std::chrono::seconds idle_after{5};  // a publisher without progress for this time counts as idle
}  // namespace

void Traffic::note(const DomainSnapshot& domain, Clock::time_point now) {
  for (const DomainSnapshot::Endpoint& publisher : domain.publishers) {
    if (!publisher.progress) continue;
    const auto [found, is_new] = entries_.try_emplace(publisher.id, Entry{*publisher.progress, now, {}});
    Entry& entry = found->second;
    if (is_new || publisher.progress->samples == entry.latest.samples) continue;
    const double passed = std::chrono::duration<double>(now - entry.changed).count();
    const auto grown = [&](std::uint64_t before, std::uint64_t after) {
      return static_cast<double>(after - std::min(before, after)) / passed;
    };
    entry.rate = {grown(entry.latest.samples, publisher.progress->samples),
                  grown(entry.latest.bytes, publisher.progress->bytes)};
    entry.latest = *publisher.progress;
    entry.changed = now;
  }
  std::erase_if(entries_, [&](const auto& item) {
    return std::ranges::find(domain.publishers, item.first, &DomainSnapshot::Endpoint::id) ==
           domain.publishers.end();
  });
}

std::optional<Traffic::Rate> Traffic::of(std::uint64_t publisher, Clock::time_point now) const {
  const auto found = entries_.find(publisher);
  if (found == entries_.end()) return std::nullopt;
  if (now - found->second.changed > idle_after) return Rate{};
  return found->second.rate;
}

}  // namespace sft::tool
