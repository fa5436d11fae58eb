#include "core/publish/gates.h"

#include <algorithm>

namespace sft::core {

namespace {
constexpr std::size_t remembered_max = 64;
}

void Gates::tidy() {
  if (gates_.size() <= remembered_max) return;
  std::erase_if(gates_, [](const Entry& entry) { return entry.gate.use_count() == 1; });
}

void Gates::give(std::span<Route> routes) {
  for (Route& route : routes) {
    const bool is_limited = route.min_period_us != 0 || !route.selection.gate().conditions.empty();
    route.gate = is_limited ? find(route) : nullptr;
  }
}

/// Finds the gate of the route, or adds it. The conditions themselves are compared, not only their hashes,
/// since a hostile reader can make conditions with any given hash.
std::shared_ptr<Gate>& Gates::find(const Route& route) {
  const std::vector<Selection::Condition>& conditions = route.selection.gate().conditions;
  const auto known = std::ranges::find_if(gates_, [&](const Entry& entry) {
    return entry.min_period_us == route.min_period_us && entry.conditions == conditions;
  });
  if (known != gates_.end()) return known->gate;
  Entry& added = gates_.emplace_back(Entry{route.min_period_us, conditions, nullptr});
  added.gate = conditions.empty()
                   ? std::make_shared<Gate>(route.min_period_us)
                   : std::make_shared<Gate>(route.min_period_us, detail::Conditions(type_.type(), conditions),
                                            route.selection.gate_hash());
  return added.gate;
}

const std::shared_ptr<Gate>& Gates::of(const Route& route) const {
  return std::ranges::find_if(gates_, [&](const Entry& entry) { return entry.gate == route.gate; })->gate;
}

void Gates::open_for(const Serving& serving) {
  std::map<EndpointId, Asked> asked;
  for (const auto* routes : {&serving.memory, &serving.network}) {
    for (const Route& route : *routes) {
      if (route.gate == nullptr || route.gate->id() == 0) continue;
      asked[route.reader] = {route.gate.get(), route.selection.hash()};
    }
  }
  for (const auto& [reader, now] : asked) {
    const auto before = asked_.find(reader);
    if (before != asked_.end() && before->second == now) continue;
    const auto is_its = [gate = now.first](const Entry& entry) { return entry.gate.get() == gate; };
    std::ranges::find_if(gates_, is_its)->gate->reader_begins();
  }
  asked_ = std::move(asked);
}

}  // namespace sft::core
