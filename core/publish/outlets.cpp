#include "core/publish/outlets.h"

#include <algorithm>
#include <utility>

namespace sft::core {

namespace {

bool holds(const std::vector<std::shared_ptr<RateGate>>& gates, const std::shared_ptr<RateGate>& gate) {
  return std::find(gates.begin(), gates.end(), gate) != gates.end();
}

void gather_gates(const std::vector<Route>& routes, const RateGates& gates, Outlets& outlets) {
  for (const Route& route : routes) {
    outlets.to_all |= route.gate == nullptr;
    if (route.gate != nullptr && !holds(outlets.gates, gates.of(route)))
      outlets.gates.push_back(gates.of(route));
  }
}

void gather_locals(const Serving& serving, Outlets& outlets) {
  for (const Route& route : serving.shm) {
    const auto is_it = [&](const Route& spare) { return spare.reader == route.reader; };
    const bool spare = outlets.has_spares && std::ranges::any_of(serving.spare, is_it);
    const auto same = [&](const Outlets::Locals& locals) {
      return locals.gate == route.gate && locals.spare == spare;
    };
    auto locals = std::find_if(outlets.locals.begin(), outlets.locals.end(), same);
    if (locals == outlets.locals.end())
      locals = outlets.locals.insert(locals, {route.gate, std::make_shared<DeliveryTally>(), spare});
    outlets.needs_shm |= route.reliable && !spare;
    outlets.page.push_back({route.reader, {.tally = locals->tally, .gate = route.gate}});
  }
}

}  // namespace

bool Outlets::provides_for(const Outlets& other) const {
  const auto asked = [this](const auto& gate) { return holds(gates, gate); };
  return mask.contains(other.mask) && (to_all || !other.to_all) && std::ranges::all_of(other.gates, asked);
}

Outlets Outlets::with(const Outlets& other) const {
  Outlets both = *this;
  both.mask |= other.mask;
  both.whole = both.mask.is_full();
  both.to_all |= other.to_all;
  for (const auto& gate : other.gates) {
    if (!holds(both.gates, gate)) both.gates.push_back(gate);
  }
  return both;
}

std::shared_ptr<Outlets> make_outlets(const TypeSupport& type, const Serving& serving, const RateGates& gates,
                                      Means means) {
  auto outlets = std::make_shared<Outlets>();
  outlets->shm = std::move(means.shm);
  outlets->to_shm = outlets->shm != nullptr && !serving.shm.empty();
  outlets->to_udp = means.udp && !serving.udp.empty();
  outlets->has_spares = outlets->to_shm && means.udp && !serving.spare.empty();
  outlets->is_wanted = outlets->to_shm || outlets->to_udp || means.retains;
  outlets->mask = outlets->to_shm || means.retains ? type.full() : type.closed(type.none());
  for (const Route& route : serving.udp) outlets->mask |= route.mask;
  outlets->whole = outlets->mask.is_full();
  gather_gates(serving.shm, gates, *outlets);
  gather_gates(serving.udp, gates, *outlets);
  gather_locals(serving, *outlets);
  return outlets;
}

}  // namespace sft::core
