#include "core/subscribe/subscriber_core.h"

#include <utility>

#include "core/subscribe/requirements.h"

namespace sft::core {

SubscriberCore::SubscriberCore(Spec spec, Doorbell& bell, std::shared_ptr<Recorder> recorder)
    : spec_(std::move(spec)),
      bell_(bell),
      recorder_(std::move(recorder)),
      events_(spec_.options.on_event),
      ports_({.patience = spec_.diverted_patience,
              .min_period_us = spec_.min_period_us,
              .copies_from_memory = spec_.copies != nullptr,
              .copies_from_network = !spec_.requirement.selection.parts().empty()},
             spec_.requirement.selection.mask()),
      waiter_(ports_, bell, spec_.poll_handle.get(), spec_.options.spin),
      callbacks_(spec_.callback, spec_.callback_clock) {
  if (spec_.copies == nullptr) return;
  remote_.emplace(type(), spec_.copies);
  requests(spec_.requirement.selection.mask(), 1);
}

void SubscriberCore::requests(const FieldMask& mask, std::uint64_t sequence) {
  ports_.requests(mask, sequence, spec_.copies == nullptr ? nullptr : plan_of(mask));
}

/// The parts are of fields that were declared, and so are always asked for.
std::shared_ptr<const detail::ProjectionPlan> SubscriberCore::plan_of(const FieldMask& mask) const {
  const Selection& declared = spec_.requirement.selection;
  return declared.parts().empty() ? std::make_shared<const detail::ProjectionPlan>(type().type(), mask)
                                  : std::make_shared<const detail::ProjectionPlan>(type(), declared);
}

void SubscriberCore::hears(const std::vector<Hearing>& hearing) {
  ports_.hears(hearing);
  // A writer that was killed between handing over its last sample and waking us did not wake us.
  waiter_.wake();
}

void SubscriberCore::look_again() {
  if (ports_.take_held_back()) waiter_.wake();  // the dispatcher then calls back, if there is a callback
}

template <class Choose>
detail::untyped::Sample SubscriberCore::take(Choose choose) {
  for (;;) {
    Next next = choose();
    if (waiter_.has_descriptor()) waiter_.settle();
    if (!next.sample) return {};
    if (next.asked == nullptr || copy_as_remote(next)) return wrap(std::move(next));
  }
}

detail::untyped::Sample SubscriberCore::take() {
  return take([this] { return ports_.take(); });
}

detail::untyped::Sample SubscriberCore::take_latest() {
  return take([this] { return ports_.take_latest(); });
}

/// Replaces the sample by a copy that has only what was asked for. False if a reader on another host would
/// have missed the sample.
bool SubscriberCore::copy_as_remote(Next& next) {
  {
    const Lock lock(remote_mutex_);
    next.sample = remote_->of(std::move(next.sample), *next.asked);
  }
  const bool is_delivered = static_cast<bool>(next.sample);
  ports_.copied(next.info, is_delivered);
  return is_delivered;
}

detail::untyped::Sample SubscriberCore::wrap(Next next) {
  return detail::untyped::Sample(next.sample.release(), *spec_.type, next.info,
                                 recorder_ == nullptr ? nullptr : recorder_->begin());
}

Result<void> SubscriberCore::set_max_rate_hz(double max_rate_hz) {
  const Result<std::uint32_t> period = min_period_us_of(max_rate_hz);
  if (!period) return tl::unexpected(period.error());
  ports_.ask(*period);
  spec_.rate_changed();
  return {};
}

bool SubscriberCore::waits_for_dispatch() {
  if (waiter_.has_descriptor()) return waiter_.has_untold();
  return callbacks_.is_idle() && available();
}

void SubscriberCore::arrived() noexcept {
  if (has_callback() && !callbacks_.is_slow()) {
    call_back(CallbackDispatch::Caller::transport);
  } else {
    waiter_.sample_arrived();
  }
}

void SubscriberCore::dispatch() {
  if (waiter_.has_descriptor()) return waiter_.tell_if_available();
  call_back(CallbackDispatch::Caller::dispatcher);
}

void SubscriberCore::call_back(CallbackDispatch::Caller caller) {
  if (!callbacks_.dispatch(caller, *this)) bell_.ring();
}

void SubscriberCore::close() {
  callbacks_.close();
  events_.clear();
}

Requirements SubscriberCore::requirements() {
  const FieldMask requested = ports_.requested();
  return recorder_ == nullptr ? declared_requirements(type(), requested)
                              : recorded_requirements(type(), requested, *recorder_);
}

SubscriberStatus SubscriberCore::status() {
  SubscriberStatus status = ports_.status();
  for (SubscriberStatus::Writer& writer : status.writers) {
    const bool as_asked = writer.transport == TransportKind::udp || spec_.memory_depth == 0;
    writer.depth = as_asked ? spec_.options.depth : spec_.memory_depth;
  }
  return status;
}

}  // namespace sft::core
