#include "udp_transport/routing/settling_times.h"

#include <algorithm>
#include <utility>

namespace sft::udp {

namespace {

bool is_same(const SettlingTimes::Asked& a, const SettlingTimes::Asked& b) {
  return a.reliable == b.reliable && a.gets_more == b.gets_more && a.min_period_us == b.min_period_us &&
         std::ranges::is_permutation(a.selections, b.selections);
}

SettlingTimes::Duration settled_after_changes(int changes) {
  SettlingTimes::Duration after = SettlingTimes::settled_after;
  for (int i = SettlingTimes::changes_in_a_row; i < changes && after < SettlingTimes::settled_after_longest;
       ++i)
    after *= 2;
  return std::min<SettlingTimes::Duration>(after, SettlingTimes::settled_after_longest);
}

}  // namespace

void SettlingTimes::note(const SocketAddress& to, Asked asked, Time now) {
  const auto [place, is_unknown] = known_.try_emplace(to);
  Known& known = place->second;
  known.noted_in = look_;
  const bool returns = !std::exchange(known.is_there, true);
  const bool is_new = is_unknown || (returns && now - known.changed_at >= row_pause);
  if (!is_new && !returns && is_same(known.asked, asked)) return;
  known.asked = std::move(asked);
  if (is_new) {
    known.changes = 0;
    known.changed_at = now;
    known.settled_at = known.gathers_until = now + gathering;
    return;
  }
  if (!returns && now < known.gathers_until) return;
  known.changes = now - known.changed_at < row_pause ? known.changes + 1 : 0;
  known.changed_at = now;
  known.settled_at = now + settled_after_changes(known.changes);
}

void SettlingTimes::end_look(Time now) {
  for (auto& [to, known] : known_) {
    if (known.noted_in != look_ && std::exchange(known.is_there, false)) known.changed_at = now;
  }
  std::erase_if(known_, [&](const auto& item) {
    return !item.second.is_there && now - item.second.changed_at >= row_pause;
  });
}

}  // namespace sft::udp
