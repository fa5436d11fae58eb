#include "core/subscribe/asked_gates.h"

#include <algorithm>
#include <utility>

namespace sft::core {

void AskedGates::ask(std::uint64_t gate) {
  if (!std::exchange(was_asked_, true)) gates_.clear();
  if (!gates_.empty() && gates_.back() == gate) return;
  gates_.push_back(gate);
  if (gates_.size() > kept_max) {
    gates_.erase(gates_.begin());
    ++oldest_;
  }
  if (gate == 0) return;
  std::erase(nameable_, gate);
  nameable_.insert(nameable_.begin(), gate);
  if (nameable_.size() > nameable_max) nameable_.pop_back();
}

void AskedGates::settle() {
  settled_ = end() - 1;
  nameable_.resize(std::min<std::size_t>(nameable_.size(), gates_.back() == 0 ? 0 : 1));
}

AskedGates::Number AskedGates::open_since(Number since) const {
  for (Number request = std::max(oldest_, since); request < end(); ++request) {
    if (gate_of(request) == 0) return request;
  }
  return since;
}

std::optional<std::uint64_t> AskedGates::only_gate_since(Number first) const {
  if (first < oldest_) return {};
  std::uint64_t only = 0;
  for (Number request = first; request < end(); ++request) {
    const std::uint64_t gate = gate_of(request);
    if (gate == 0 || gate == only) continue;
    if (only != 0) return {};
    only = gate;
  }
  return only;
}

}  // namespace sft::core
