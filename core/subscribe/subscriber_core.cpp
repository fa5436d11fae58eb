#include "core/subscribe/subscriber_core.h"

#include <utility>

#include "core/control/qos.h"
#include "core/negotiation/requested_selection.h"
#include "core/subscribe/requirements.h"

namespace sft::core {

SubscriberCore::SubscriberCore(Spec spec, Doorbell& bell, std::shared_ptr<Recorder> recorder)
    : spec_(std::move(spec)),
      bell_(bell),
      recorder_(std::move(recorder)),
      declared_(spec_.requirement.selection),
      remote_(spec_.copies == nullptr ? nullptr : RemoteCopy::make(type(), spec_.copies)),
      events_(spec_.options.on_event),
      ports_({.patience = spec_.diverted_patience,
              .min_period_us = spec_.min_period_us,
              .slots = type().slots()},
             make_asked(type(), declared_, spec_.options.recording.as_remote, recorder_.get()),
             spec_.requirement.limits_samples || (recorder_ != nullptr && recorder_->records_channels())),
      waiter_(ports_, bell, spec_.poll_handle.get(), spec_.options.spin),
      callbacks_(spec_.callback, spec_.callback_clock) {}

void SubscriberCore::requests(Selection selection, std::uint64_t sequence) {
  if (selection == ports_.requested()) return ports_.requests(nullptr, sequence);
  ports_.requests(
      make_asked(type(), std::move(selection), spec_.options.recording.as_remote, recorder_.get()), sequence);
}

Selection SubscriberCore::required() const {
  const Selection declared = [this] {
    const Lock lock(selection_mutex_);
    return declared_;
  }();
  if (recorder_ == nullptr) return declared;
  const Selection fields = type().closed(recorder_->required());
  return fields.with_gate(declared.gate())
      .value_or(fields);  // without conditions if all is too long together
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
    Delivery next{choose()};
    if (waiter_.has_descriptor()) waiter_.settle();
    if (!next.sample) return {};
    if (!next.is_copied || reduce(next)) return wrap(std::move(next));
  }
}

detail::untyped::Sample SubscriberCore::take() {
  return take([this] { return ports_.take(); });
}

detail::untyped::Sample SubscriberCore::take_latest() {
  return take([this] { return ports_.take_latest(); });
}

/// Leaves in the sample only what was asked for. False if a reader on another host would have missed the
/// sample. Views of compiled types read parts of fields where they are; others read one body.
bool SubscriberCore::reduce(Delivery& delivery) {
  const detail::ProjectionPlan* const plan = delivery.asked->plan.get();
  if (plan != nullptr && spec_.requirement.limits_samples) {
    delivery.sample = remote_->of(std::move(delivery.sample), *plan);
  } else if (plan != nullptr) {
    RemoteCopy::InPlace reduced = remote_->in_place(std::move(delivery.sample), delivery.asked);
    delivery.sample = std::move(reduced.sample);
    delivery.parts = reduced.parts;
  }
  const bool is_delivered = static_cast<bool>(delivery.sample);
  ports_.copied(delivery.info, is_delivered);
  return is_delivered;
}

detail::untyped::Sample SubscriberCore::wrap(Delivery delivery) {
  const std::shared_ptr<const Asked>& asked = delivery.asked;
  std::shared_ptr<const Selection> selection;
  if (asked != nullptr && recorder_ == nullptr) selection = {asked, &asked->selection};
  RecordedSample* const record = recorder_ == nullptr ? nullptr : recorder_->begin();
  if (record != nullptr && delivery.sample->parts != 0 && asked != nullptr && asked->recorded_channels)
    record->set_channels_sent({asked, &*asked->recorded_channels});
  return detail::untyped::Sample(delivery.sample.release(), type(), delivery.info, record,
                                 std::move(selection), delivery.parts);
}

Result<void> SubscriberCore::set_max_rate_hz(double max_rate_hz) {
  const Result<std::uint32_t> period = min_period_us_of(max_rate_hz);
  if (!period) return tl::unexpected(period.error());
  ports_.ask(*period);
  spec_.rate_changed();
  return {};
}

Result<void> SubscriberCore::set_selection(const Selection& selection) {
  if (recorder_ != nullptr) {
    return fail(Errc::invalid_argument,
                "topic '" + spec_.topic + "': the subscriber records its fields; open one with a selection");
  }
  const Result<Selection> asked = checked_selection(type(), selection);
  if (!asked) return tl::unexpected(asked.error());
  const Result<std::uint32_t> period = min_period_us_of(rate_hz_of(*asked));
  if (!period) return tl::unexpected(period.error());
  if (*period != 0) ports_.ask(*period);
  {
    const Lock lock(selection_mutex_);
    declared_ = asked->without_rate();
  }
  spec_.requirement_changed();
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
  const Selection requested = ports_.requested();
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
