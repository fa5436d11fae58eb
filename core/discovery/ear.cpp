#include "core/discovery/ear.h"

#include "core/discovery/life_signs.h"

namespace sft::core {

void SignsHeard::full_sign_came(NodeId node, std::chrono::milliseconds its_lease, Time now) {
  if (named.size() < Ear::nodes_max) named.insert(node);
  last_full = now;
  lease = its_lease;
  full_given.reset();
  full_missed = 0;
  unnamed.reset();
  overdue_since.reset();
  if (gives_pulses(lease) && !last_pulse) last_pulse = now;  // they are expected from now on
}

/// A pulse that may have come before the last full sign does not tell whether that was the last one.
void SignsHeard::pulse_came(const Pulse& pulse, Time since, Time now) {
  last_pulse = now;
  if (!full_given && since > last_full) full_given = pulse.full_signs;
  if (full_given) full_missed = static_cast<std::uint8_t>(pulse.full_signs - *full_given);
}

void SignsHeard::unnamed_pulse_came(const Pulse& pulse, Time now) {
  if (!unnamed || now - unnamed->last > Ear::heard_lately)
    unnamed = {.first = now, .last = now, .full_given = pulse.full_signs};
  unnamed->last = now;
  unnamed->full_missed = static_cast<std::uint8_t>(pulse.full_signs - unnamed->full_given);
}

bool SignsHeard::none_comes_for(std::chrono::milliseconds duration, Time now) const {
  return unnamed && now - unnamed->last < Ear::heard_lately && unnamed->last - unnamed->first > duration;
}

bool Ear::lives_by(NodeId node_of_sign, std::uint32_t digest, Time since, Time now) {
  last = last_life = now;
  if (since < signs.told_at) return false;
  signs.told_at = since;
  told = digest;
  const bool agrees = told == known;
  if (agrees) {
    agreed = now;
    has_agreed = true;
    shared = digest;
    if (nodes.size() < nodes_max) nodes.insert(node_of_sign);
  }
  is_contradicted = has_agreed && digest == shared && digest != known && since - changed > overtaking;
  return agrees;
}

bool Ear::is_doubtful_for(std::chrono::milliseconds duration, bool is_doubtful, Time now) {
  if (!is_doubtful) {
    doubtful_since.reset();
    return false;
  }
  if (!doubtful_since) doubtful_since = now;
  return now - *doubtful_since >= duration;
}

}  // namespace sft::core
