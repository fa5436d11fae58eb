#include "tools/demo/screen/figures.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

namespace sft::demo {

namespace {

/// A figure that was not measured is null. One decimal is enough: no figure is more exact than that.
nlohmann::ordered_json number(const std::optional<double>& value) {
  if (!value) return nullptr;
  return std::round(*value * 10) / 10;
}

nlohmann::ordered_json to_json(const SubscriberFigures& s) {
  return {
      {"name", s.name},
      {"transport", s.transport},
      {"reason", s.reason},
      {"fields", s.fields},
      {"requirement", s.recorded ? "recorded" : "declared"},
      {"received", s.received},
      {"lost", s.lost},
      {"withheld", s.withheld},
      {"full_bytes_per_sample", number(s.full_bytes_per_sample)},
      {"wire_bytes_per_sample", number(s.wire_bytes_per_sample)},
      {"learning_bytes", number(s.learning_bytes)},
      {"latency_us", {{"p50", number(s.latency_p50_us)}, {"p99", number(s.latency_p99_us)}}},
  };
}

bool is_part(const std::string& field) { return field.find_first_of("{[") != std::string::npos; }

/// If there are parts, all fields are named, because "all" and "all but" cannot describe parts.
std::string format_fields(const SubscriberFigures& subscriber) {
  if (subscriber.fields.empty()) return "none";
  if (std::ranges::any_of(subscriber.fields, is_part))
    return fmt::format("{}", fmt::join(subscriber.fields, ", "));
  if (subscriber.other_fields.empty()) return "all";
  if (subscriber.fields.size() <= subscriber.other_fields.size())
    return fmt::format("{}", fmt::join(subscriber.fields, ", "));
  return fmt::format("all but {}", fmt::join(subscriber.other_fields, ", "));
}

}  // namespace

double SubscriberFigures::saved() const {
  if (full_bytes_per_sample <= 0 || received == 0) return 0;
  const double due = static_cast<double>(received + withheld);
  return 1 - sent_bytes_per_sample() * static_cast<double>(received) / due / full_bytes_per_sample;
}

std::uint64_t RunFigures::lost() const {
  std::uint64_t sum = 0;
  for (const SubscriberFigures& s : subscribers) sum += s.lost;
  return sum;
}

Carried RunFigures::carried() const {
  Carried sum;
  for (const SubscriberFigures& s : subscribers) {
    if (s.in_shared_memory()) continue;
    sum.bytes += s.wire_bytes.value_or(s.payload_bytes);
    sum.whole_bytes += s.full_bytes_per_sample * static_cast<double>(samples);
  }
  return sum;
}

nlohmann::ordered_json to_json(const RunFigures& figures) {
  nlohmann::ordered_json subscribers = nlohmann::ordered_json::array();
  for (const SubscriberFigures& s : figures.subscribers) subscribers.push_back(to_json(s));
  const Carried carried = figures.carried();
  return {
      {"samples", figures.samples},
      {"hosts", figures.hosts},
      {"carried_bytes", number(carried.bytes)},
      {"whole_bytes", number(carried.whole_bytes)},
      {"subscribers", subscribers},
  };
}

std::string format_request(const SubscriberFigures& subscriber) {
  const std::string fields = format_fields(subscriber);
  return subscriber.max_rate_hz > 0 ? fmt::format("{}, {:g} Hz", fields, subscriber.max_rate_hz) : fields;
}

}  // namespace sft::demo
