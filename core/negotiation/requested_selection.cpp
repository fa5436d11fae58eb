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

namespace {

/// Returns an error if a part refers to another layout rule than that of our type, since the part's rows
/// and columns would then mean other elements.
Result<Selection> with_our_rules(const TypeSupport& type, const Selection& asked) {
  for (const Selection::Part& part : asked.parts()) {
    const detail::Layout* const layout = type.layout_of(part.leaf);
    if (part.rule == (layout == nullptr ? 0 : layout->rule)) continue;
    return fail(
        Errc::type_mismatch,
        "the part of " + type.path(part.leaf) +
            " is meant by another layout rule (@sft_layout) than the one that the publisher was built "
            "with; build both programs from one definition of the type");
  }
  return asked;
}

}  // namespace

Result<Selection> requested_selection(const Request& request, const TypeSupport& type) {
  const FieldMask fields = FieldMask::from_words(type.leaves(), request.mask_words);
  if (request.parts.empty()) return Selection(type.closed(fields));
  return Selection::from_bytes(request.parts, type.leaves())
      .and_then([&](const Selection& some) {
        const std::span<const Selection::Part> parts = some.parts();
        return Selection::make(fields, {parts.begin(), parts.end()}, {some.gate().conditions, {}});
      })
      .and_then([&](const Selection& asked) { return with_our_rules(type, asked); })
      .and_then([&](const Selection& asked) { return checked_selection(type, asked); });
}

}  // namespace sft::core
