#include "core/subscribe/asked_gates.h"

#include <algorithm>
#include <utility>

namespace sft::core {

void AskedGates::ask(std::uint64_t gate, bool is_limited) {
  const Request asked{gate, is_limited};
  if (!std::exchange(was_asked_, true)) requests_.clear();
  if (!requests_.empty() && requests_.back() == asked) return;
  requests_.push_back(asked);
  if (requests_.size() > kept_max) {
    requests_.erase(requests_.begin());
    ++oldest_;
  }
  if (gate == 0) return;
  std::erase(nameable_, gate);
  nameable_.insert(nameable_.begin(), gate);
  if (nameable_.size() > nameable_max) nameable_.pop_back();
}

void AskedGates::settle(Number request) {
  settled_ = std::max(settled_, request);
  const Number first = std::max(oldest_, settled_);
  const auto settled = requests_.begin() + static_cast<std::ptrdiff_t>(first - oldest_);
  std::erase_if(nameable_, [&](std::uint64_t gate) {
    return std::find_if(settled, requests_.end(), [gate](const Request& r) { return r.gate == gate; }) ==
           requests_.end();
  });
}

AskedGates::Number AskedGates::open_since(Number since) const {
  if (since < oldest_) return since;
  for (Number request = since; request < end(); ++request) {
    const std::uint64_t gate = at(request).gate;
    if (gate == 0) return request;
    if (std::ranges::find(nameable_, gate) == nameable_.end()) return since;
  }
  return since;
}

/// Returns nothing also if a request has a maximum rate but no conditions, because it may have withheld
/// samples that passed the gate.
std::optional<std::uint64_t> AskedGates::only_gate_since(Number first) const {
  if (first < oldest_) return {};
  std::uint64_t only = 0;
  bool is_limited = false;
  for (Number request = first; request < end(); ++request) {
    const auto [gate, limited] = at(request);
    if (gate == 0) is_limited = is_limited || limited;
    if (gate == 0 || gate == only) continue;
    if (only != 0) return {};
    only = gate;
  }
  if (only != 0 && is_limited) return {};
  return only;
}

bool AskedGates::asks_for_all_since(Number first) const {
  if (first < oldest_) return false;
  for (Number request = first; request < end(); ++request)
    if (at(request) != Request{}) return false;
  return true;
}

}  // namespace sft::core
