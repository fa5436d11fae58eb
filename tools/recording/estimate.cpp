#include "tools/recording/estimate.h"

#include <algorithm>
#include <chrono>
#include <cstring>
#include <limits>
#include <utility>

namespace sft::recording {

TopicEstimate::TopicEstimate(DynamicType type, const Selection* selection)
    : type_(std::move(type)), full_(type_.support().full()) {
  if (selection == nullptr) return;
  selection_ = *selection;
  plan_.emplace(type_.support(), *selection);
  const auto& conditions = selection->gate().conditions;
  if (!conditions.empty()) conditions_ = detail::Conditions(type_.type(), conditions);
}

/// Adds the bytes of each member of a struct at `offset`. The members of nested single structs are counted
/// separately.
void TopicEstimate::measure(const detail::SampleState& state, const StructType& type, std::size_t leaf,
                            std::uint64_t offset, const std::string& prefix) {
  for (const StructType::Member& m : type.members) {
    const std::uint32_t end = detail::skip(state, m, leaf, offset);
    if (end == detail::no_offset) return;  // build_index() has checked the bytes
    const std::string path = prefix + std::string(m.name);
    if (m.kind == StructType::Member::Kind::structure && m.shape == StructType::Member::Shape::single) {
      measure(state, *m.type, leaf, offset, path + ".");
    } else {
      fields_[path] += end - offset;
    }
    leaf += leaf_count(m);
    offset = end;
  }
}

bool TopicEstimate::passes(const detail::SampleState& state, std::int64_t stamp_ns) {
  const auto source = detail::FieldSource::of_sample(state);
  if (!conditions_.empty() && !conditions_.hold(source, stamp_ns)) return false;
  const std::int64_t period_ns = std::chrono::nanoseconds(selection_->gate().least_period).count();
  if (period_ns != 0) {
    const std::int64_t slot = stamp_ns / period_ns;
    if (slot_ == slot) return false;
    slot_ = slot;
  }
  if (!conditions_.empty()) conditions_.passed(source, stamp_ns);
  return true;
}

Result<void> TopicEstimate::add(std::span<const std::byte> cdr, std::uint64_t log_ns) {
  const bool is_little_endian =
      cdr.size() >= detail::encapsulation_bytes && cdr[0] == std::byte{0} && cdr[1] == std::byte{1};
  if (!is_little_endian) return fail(Errc::malformed, "it is no little-endian CDR");
  const auto body = cdr.subspan(detail::encapsulation_bytes);
  if (body.size() >= std::numeric_limits<std::uint32_t>::max())
    return fail(Errc::limit_exceeded, "it is too large");
  body_.resize(body.size() / 8 + 1);
  std::ranges::copy(body, std::as_writable_bytes(std::span(body_)).begin());
  index_.resize(type_.support().index_slots());
  const detail::SampleState state{.body = reinterpret_cast<const std::byte*>(body_.data()),
                                  .body_bytes = static_cast<std::uint32_t>(body.size()),
                                  .index = index_.data(),
                                  .mask = &full_};
  std::uint32_t end = 0;
  if (const auto status = detail::build_index(state, type_.type(), index_, &end);
      status != detail::WalkStatus::ok)
    return fail(Errc::type_mismatch, std::string("it does not fit its type: ") + to_string(status));
  ++samples_;
  bytes_ += end;
  measure(state, type_.type(), 0, 0, "");
  if (!selection_) {
    ++selected_samples_;
    selected_bytes_ += end;
  } else if (passes(state, static_cast<std::int64_t>(log_ns)) && projection_.project(state, *plan_)) {
    ++selected_samples_;
    selected_bytes_ += projection_.bytes();
  }
  return {};
}

std::vector<TopicEstimate::Field> TopicEstimate::fields() const {
  std::vector<Field> list;
  for (const auto& [path, bytes] : fields_) list.push_back({path, bytes});
  std::ranges::stable_sort(list, [](const Field& a, const Field& b) { return a.bytes > b.bytes; });
  return list;
}

}  // namespace sft::recording
