#include "core/node/local_writer.h"

#include <algorithm>
#include <utility>

#include "core/report/events.h"

namespace sft::core {

namespace {
constexpr std::chrono::milliseconds reach_again_after{1000};
constexpr int progress_times = 3;
}  // namespace

LocalWriter::LocalWriter(NodeContext& node, const Endpoint& endpoint, std::shared_ptr<PublisherCore> core)
    : node_(node),
      id_(endpoint.id),
      core_(std::move(core)),
      vanilla_(node, *core_),
      monitor_(endpoint.qos, std::chrono::steady_clock::now()) {}

void LocalWriter::reconcile() {
  const Time now = std::chrono::steady_clock::now();
  Serving wanted = desired(now);
  if (open_memory(wanted.memory_port)) wanted = desired(now);
  wanted = reachable(std::move(wanted), now);
  const bool has_other_port = vanilla_.reconcile(now);
  if (in_force_ == wanted && !has_other_port) return;
  const bool as_before = in_force_ && in_force_->serves_like(wanted) && !has_other_port;
  in_force_ = wanted;
  has_changes_ = true;
  as_before ? core_->show(wanted.readers) : core_->serve(wanted, memory_, vanilla_.port());
  if (has_other_port) vanilla_.in_force();
}

/// Returns the desired state. Readers whose doorbells could not be rung are left out of shared memory until
/// they are due again.
Serving LocalWriter::desired(Time now) const {
  Negotiation::Unreachable unreachable;
  for (const auto& [reader, retry] : reaching_) {
    if (!retry.due(now)) unreachable.emplace(reader, retry.reason());
  }
  return node_.negotiation.serving(id_, unreachable);
}

/// Opens the port in shared memory if `wanted` is true and the port is not open. Returns true if the
/// desired state may have changed, because the port can reach further readers.
bool LocalWriter::open_memory(bool wanted) {
  if (!wanted || memory_ != nullptr) {
    opening_memory_ = {};
    return false;
  }
  const bool opened = node_.attempts.in_memory(opening_memory_, [this]() -> Result<void> {
    auto port =
        node_.memory->open_writer({id_, &core_->type(), core_->retains(), core_->spec().max_blocking});
    if (!port) return tl::unexpected(port.error());
    memory_ = std::move(*port);
    in_force_.reset();
    return {};
  });
  return opened && reach_all_again();
}

/// Returns the part of `wanted` that is possible: a reader is served in shared memory only if the port can
/// ring its doorbell.
Serving LocalWriter::reachable(Serving wanted, Time now) {
  forget_unreached_but(wanted);
  bool changed = false;
  for (const Route& route : wanted.memory) {
    if (is_served_already(route)) continue;
    const std::string why_not = memory_ == nullptr ? why_not_open() : memory_->why_unreachable(route);
    if (why_not.empty()) {
      reaching_.erase(route.reader);
    } else {
      changed = true;
      cannot_reach(route, why_not, now);
    }
  }
  return changed ? desired(now) : wanted;
}

/// Returns the reason why the port in shared memory is not open. (A reader may be attached even to a port
/// that is not open here, if the daemon has created the port but answered too late.)
std::string LocalWriter::why_not_open() const {
  return "the publisher's port in shared memory is not open: " + opening_memory_.reason();
}

/// Discards failures to reach readers that are not attached any more. Such readers may be reachable when they
/// attach again.
void LocalWriter::forget_unreached_but(const Serving& wanted) {
  std::erase_if(reaching_, [&](const auto& item) {
    const auto is_it = [&](const Route& route) { return route.reader == item.first; };
    return std::ranges::none_of(wanted.memory, is_it) && std::ranges::none_of(wanted.unreached, is_it);
  });
}

bool LocalWriter::is_served_already(const Route& route) const {
  return in_force_ && std::ranges::any_of(in_force_->memory, [&](const Route& before) {
           return before.reader == route.reader && before.destination == route.destination;
         });
}

void LocalWriter::cannot_reach(const Route& route, const std::string& why_not, Time now) {
  if (!reaching_[route.reader].failed(why_not, now, reach_again_after)) return;
  if (memory_ == nullptr) return;  // the failure to open the port has been logged already
  const TableEntry* reader = node_.negotiation.table().find(route.reader);
  node_.log.write(LogLevel::warning, core_->spec().topic + ": the subscriber of node '" +
                                         (reader == nullptr ? "" : reader->endpoint.node) +
                                         "' is not served in shared memory: " + why_not);
}

bool LocalWriter::look_after_reach(Time now) {
  if (memory_ == nullptr) return false;  // these readers are tried again once the port is open
  bool any_due = false;
  for (auto& [reader, retry] : reaching_) {
    if (!retry.due_again(now)) continue;
    retry.hold(Time{});  // from now on, desired() contains the reader
    any_due = true;
  }
  return any_due;
}

bool LocalWriter::look_after_history() {
  core_->expire_history();
  core_->give_history();
  if (!owes_history()) return false;
  bool changed = false;
  const std::set<EndpointId> before = std::exchange(history_sent_, {});
  for (const Route& route : in_force_->network) {
    if (route.history == 0 || !core_->history_sent(route.reader)) continue;
    history_sent_.insert(route.reader);
    if (before.contains(route.reader)) changed |= node_.negotiation.history_given(id_, route.reader);
  }
  return changed;
}

/// Discards all failures to reach readers. Returns true if there were any.
bool LocalWriter::reach_all_again() { return !std::exchange(reaching_, {}).empty(); }

bool LocalWriter::drop_memory() {
  opening_memory_ = {};
  const bool changed = reach_all_again();
  if (memory_ == nullptr) return changed;
  memory_.reset();
  in_force_.reset();
  return changed;
}

bool LocalWriter::watch_promises(Time now) {
  const OfferMonitor::Signs signs = core_->signs();
  monitor_.look(signs, now);
  has_changes_ |= core_->keeps_promises(monitor_.deadlines_missed(), monitor_.alive());
  if (!monitor_.rests(now)) core_->listen_for_assertions();
  return in_force_ && in_force_->lease_requested &&
         monitor_.assertion_due(signs, in_force_->samples_assert, now);
}

std::optional<Progress> LocalWriter::take_progress(bool again) {
  const std::uint64_t published = core_->signs().published;
  if (!has_readers() || published == 0) return std::nullopt;
  const bool is_new = std::exchange(progress_reported_, published) != published;
  if (again || is_new) progress_left_ = progress_times;
  if (progress_left_ == 0) return std::nullopt;
  --progress_left_;
  return core_->progress();
}

std::uint64_t LocalWriter::sent_in_memory() const {
  return in_force_ && !in_force_->memory.empty() ? core_->signs().published : 0;
}

/// Reports events. States are copied and compared only if a change is possible.
void LocalWriter::report_events() {
  has_changes_ |= core_->diverted() != reported_.diverted;
  if (!std::exchange(has_changes_, false)) return;
  core::report_events(
      *core_, reported_, node_.log, [this] { return core_->status(); },
      [this](const PublisherStatus& before, const PublisherStatus& now) {
        return events_between(before, now, core_->type());
      });
}

std::vector<EndpointId> LocalWriter::matching_readers() const {
  std::vector<EndpointId> readers;
  if (!in_force_) return readers;
  for (const PublisherStatus::Reader& reader : in_force_->readers) {
    if (!reader.incompatible_type && reader.incompatible_policy == QosPolicy::none)
      readers.push_back(reader.id);
  }
  return readers;
}

DomainSnapshot::Sent LocalWriter::account_of(EndpointId reader) const {
  const Delivered delivered = core_->delivered(reader);
  const PublisherStatus::Diverted diverted = core_->diverted();
  return {.sent = delivered.sent,
          .withheld = delivered.withheld,
          .dropped = delivered.dropped,
          .retained = delivered.retained,
          .bytes_sent = delivered.bytes,
          .bytes_saved = delivered.bytes_saved,
          .diverted = delivered.diverted,
          .too_large_bytes = diverted.too_large_bytes,
          .chunk_bytes = diverted.chunk_bytes};
}

}  // namespace sft::core
