#include "core/publish/rate_gates.h"

namespace sft::core {

namespace {
constexpr std::size_t remembered_max = 64;
}

void RateGates::tidy() {
  if (gates_.size() <= remembered_max) return;
  std::erase_if(gates_, [](const auto& item) { return item.second.use_count() == 1; });
}

void RateGates::give(std::span<Route> routes) {
  for (Route& route : routes) {
    route.gate = nullptr;
    if (route.min_period_us == 0) continue;
    std::shared_ptr<RateGate>& gate = gates_[route.min_period_us];
    if (gate == nullptr) gate = std::make_shared<RateGate>(route.min_period_us);
    route.gate = gate;
  }
}

}  // namespace sft::core
