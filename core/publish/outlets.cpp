#include "core/publish/outlets.h"

#include <algorithm>
#include <utility>

namespace sft::core {

namespace {

bool holds(const std::vector<std::shared_ptr<Gate>>& gates, const std::shared_ptr<Gate>& gate) {
  return std::find(gates.begin(), gates.end(), gate) != gates.end();
}

void gather_gates(const std::vector<Route>& routes, const Gates& gates, Outlets& outlets) {
  for (const Route& route : routes) {
    outlets.to_all |= route.gate == nullptr;
    if (route.gate != nullptr && !holds(outlets.gates, gates.of(route)))
      outlets.gates.push_back(gates.of(route));
  }
}

void gather_memory_gates(const Serving& serving, const Gates& gates, Outlets& outlets) {
  if (!outlets.to_memory) return;
  for (const Route& route : serving.memory) {
    if (route.has_conditions() && !holds(outlets.memory_gates, gates.of(route)))
      outlets.memory_gates.push_back(gates.of(route));
  }
}

void gather_memory_groups(const Serving& serving, Outlets& outlets) {
  for (const Route& route : serving.memory) {
    const auto is_it = [&](const Route& fallback) { return fallback.reader == route.reader; };
    const bool has_fallback = outlets.has_fallback && std::ranges::any_of(serving.fallback, is_it);
    const auto same = [&](const Outlets::MemoryGroup& known) {
      return known.gate == route.gate && known.have_fallback == has_fallback;
    };
    auto group = std::find_if(outlets.memory_groups.begin(), outlets.memory_groups.end(), same);
    if (group == outlets.memory_groups.end())
      group =
          outlets.memory_groups.insert(group, {route.gate, std::make_shared<DeliveryTally>(), has_fallback});
    outlets.needs_memory |= route.reliable && !has_fallback;
    outlets.page.push_back({route.reader, {.tally = group->tally, .gate = route.gate}});
  }
}

}  // namespace

bool Outlets::provides_for(const Outlets& other) const {
  const auto asked = [this](const auto& gate) { return holds(gates, gate); };
  const auto named = [this](const auto& gate) { return holds(memory_gates, gate); };
  return mask.contains(other.mask) && (to_all || !other.to_all) && std::ranges::all_of(other.gates, asked) &&
         (!to_memory || std::ranges::all_of(other.memory_gates, named));
}

Outlets Outlets::with(const Outlets& other) const {
  Outlets both = *this;
  both.mask |= other.mask;
  both.whole = both.mask.is_full();
  both.to_all |= other.to_all;
  for (const auto& gate : other.gates) {
    if (!holds(both.gates, gate)) both.gates.push_back(gate);
  }
  for (const auto& gate : other.memory_gates) {
    if (!holds(both.memory_gates, gate)) both.memory_gates.push_back(gate);
  }
  return both;
}

std::shared_ptr<Outlets> make_outlets(const TypeSupport& type, const Serving& serving, const Gates& gates,
                                      Means means) {
  auto outlets = std::make_shared<Outlets>();
  outlets->memory = std::move(means.memory);
  outlets->to_memory = outlets->memory != nullptr && !serving.memory.empty();
  outlets->to_network = means.network && !serving.network.empty();
  outlets->has_fallback = outlets->to_memory && means.network && !serving.fallback.empty();
  outlets->vanilla = std::move(means.vanilla);
  const bool to_vanilla = outlets->vanilla != nullptr;
  outlets->is_wanted = outlets->to_memory || outlets->to_network || to_vanilla || means.retains;
  outlets->to_all = to_vanilla;
  outlets->mask = outlets->to_memory || to_vanilla || means.retains ? type.full() : type.closed(type.none());
  for (const Route& route : serving.network) outlets->mask |= route.selection.mask();
  outlets->whole = outlets->mask.is_full();
  gather_gates(serving.memory, gates, *outlets);
  gather_gates(serving.network, gates, *outlets);
  gather_memory_gates(serving, gates, *outlets);
  gather_memory_groups(serving, *outlets);
  return outlets;
}

}  // namespace sft::core
