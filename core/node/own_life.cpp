#include "core/node/own_life.h"

#include <optional>
#include <utility>

namespace sft::core {

namespace {
constexpr std::chrono::milliseconds told_more_pause{500};
/// At least one sign is given within that time.
constexpr std::chrono::milliseconds tells_progress_again_for{1500};
}  // namespace

/// Not more than two signs of life in a second tell more than that: a node that keeps a short lease gives far
/// more of them.
Assertion OwnLife::next_sign(std::vector<EndpointId> living, LocalEndpoints& ours, AccountDesk& accounts,
                             Time met_at, Time now) {
  told_at_ = now;
  if (std::exchange(has_newcomer_, false)) newcomers_told_at_ = now;
  Assertion sign{id_, std::move(living)};
  if (now < told_more_at_ + told_more_pause) return sign;
  sign.progress = take_progress(ours, now - met_at < tells_progress_again_for);
  accounts.fill_in(sign, now);
  const bool tells_accounts = !sign.asked_about.empty() || !sign.accounts.empty();
  if (tells_accounts) accounts_told_at_ = now;
  if (tells_accounts || !sign.progress.empty()) told_more_at_ = now;
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
