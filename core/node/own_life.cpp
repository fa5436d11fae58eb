#include "core/node/own_life.h"

#include <optional>
#include <utility>

namespace sft::core {

namespace {
constexpr std::chrono::milliseconds progress_is_told_again_for{2500};
}  // namespace

Assertion OwnLife::next_sign(std::vector<EndpointId> living, LocalEndpoints& ours, AccountDesk& accounts,
                             Time newcomer_at, Time now) {
  Assertion sign{id_, std::move(living)};
  if (!is_sign_due(now)) return sign;
  told_at_ = now;
  sign.progress = take_progress(ours, now - newcomer_at < progress_is_told_again_for);
  accounts.fill_in(sign, now);
  return sign;
}

/// The progress of writers that have sent something since they were named last, in turns. `again`: that of
/// all that have ever sent anything.
std::vector<Progress> OwnLife::take_progress(LocalEndpoints& ours, bool again) {
  std::vector<Progress> all;
  progress_turns_.go_round(ours.writers, progress_max, [&](auto& item) {
    const std::optional<Progress> progress = item.second.take_progress(again);
    if (progress) all.push_back(*progress);
    return progress.has_value();
  });
  return all;
}

}  // namespace sft::core
