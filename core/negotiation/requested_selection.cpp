#include "core/negotiation/requested_selection.h"

#include <span>
#include <string>

#include "sft/detail/conditions.h"

namespace sft::core {

Result<Selection> checked_selection(const TypeSupport& type, const Selection& selection) {
  if (selection.mask().leaves() != type.leaves()) {
    return fail(Errc::invalid_argument,
                "the selection was made for another type than " + std::string(type.name()));
  }
  if (const auto fits = detail::Conditions::check(type.type(), selection.gate().conditions); !fits)
    return tl::unexpected(fits.error());
  return type.closed(selection);
}

double rate_hz_of(const Selection& selection) {
  const auto period_us = static_cast<double>(selection.gate().least_period.count());
  return period_us == 0 ? 0 : 1e6 / period_us;
}

Result<Selection> requested_selection(const Request& request, const TypeSupport& type) {
  const FieldMask fields = FieldMask::from_words(type.leaves(), request.mask_words);
  if (request.parts.empty()) return Selection(type.closed(fields));
  return Selection::from_bytes(request.parts, type.leaves())
      .and_then([&](const Selection& some) {
        const std::span<const Selection::Part> parts = some.parts();
        return Selection::make(fields, {parts.begin(), parts.end()}, {some.gate().conditions, {}});
      })
      .and_then([&](const Selection& asked) { return checked_selection(type, asked); });
}

}  // namespace sft::core
