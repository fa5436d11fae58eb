#include "core/subscribe/feed.h"

#include <string>
#include <utility>

#include "core/names/qos.h"
#include "core/negotiation/requested_selection.h"
#include "core/subscribe/requirements.h"

namespace sft::core {

Feed::Feed(Spec spec, const Common& common)
    : spec_(std::move(spec)),
      common_(common),
      declared_(spec_.selection),
      ports_({.timeout = common.timeout,
              .min_period_us = spec_.min_period_us,
              .slots = common.type.index_slots()},
             asked(spec_.selection), common.reports_asked) {}

Selection Feed::required() const {
  const Selection declared = [this] {
    const Lock lock(mutex_);
    return declared_;
  }();
  if (common_.recorder == nullptr) return declared;
  const Selection fields = common_.type.closed(common_.recorder->required());
  return fields.with_gate(declared.gate())
      .value_or(fields);  // without conditions if the selection would be too long with them
}

Result<void> Feed::set_max_rate_hz(double max_rate_hz) {
  const Result<std::uint32_t> period = min_period_us_of(max_rate_hz);
  if (!period) return tl::unexpected(period.error());
  ports_.ask(*period);
  spec_.changed();
  return {};
}

Result<void> Feed::set_selection(const Selection& other) {
  if (common_.recorder != nullptr) {
    return fail(Errc::invalid_argument,
                "topic '" + std::string(common_.topic) +
                    "': the subscriber records its fields; open one with a selection");
  }
  const Result<Selection> asked = checked_selection(common_.type, other);
  if (!asked) return tl::unexpected(asked.error());
  const Result<std::uint32_t> period = min_period_us_of(rate_hz_of(*asked));
  if (!period) return tl::unexpected(period.error());
  if (*period != 0) ports_.ask(*period);
  {
    const Lock lock(mutex_);
    declared_ = asked->without_rate();
  }
  spec_.changed();
  return {};
}

void Feed::requests(Selection selection, std::uint64_t sequence) {
  if (selection == ports_.requested()) return ports_.requests(nullptr, sequence);
  ports_.requests(asked(std::move(selection)), sequence);
}

Requirements Feed::requirements() {
  const Selection requested = ports_.requested();
  return common_.recorder == nullptr ? declared_requirements(common_.type, requested)
                                     : recorded_requirements(common_.type, requested, *common_.recorder);
}

SubscriberStatus Feed::status() {
  SubscriberStatus status = ports_.status();
  status.long_waits = long_waits_.load(std::memory_order_relaxed);
  for (SubscriberStatus::Writer& writer : status.writers) {
    const bool as_asked = writer.transport != TransportKind::shm || common_.memory_depth == 0;
    writer.depth = as_asked ? common_.depth : common_.memory_depth;
  }
  return status;
}

}  // namespace sft::core
