#include "examples/demo/figures.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <nlohmann/json.hpp>

namespace sft::demo {

namespace {

/// JSON has no figure for what was not measured but null. A tenth is more than is known.
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
      {"full_bytes_per_sample", number(s.full_bytes_per_sample)},
      {"wire_bytes_per_sample", number(s.wire_bytes_per_sample)},
      {"learning_bytes", number(s.learning_bytes)},
      {"latency_us", {{"p50", number(s.latency_p50_us)}, {"p99", number(s.latency_p99_us)}}},
  };
}

}  // namespace

std::optional<double> SubscriberFigures::saved() const {
  if (!wire_bytes_per_sample || full_bytes_per_sample <= 0) return std::nullopt;
  return 1 - *wire_bytes_per_sample / full_bytes_per_sample;
}

nlohmann::ordered_json to_json(const RunFigures& figures) {
  nlohmann::ordered_json subscribers = nlohmann::ordered_json::array();
  for (const SubscriberFigures& s : figures.subscribers) subscribers.push_back(to_json(s));
  return {
      {"input", figures.input},     {"samples", figures.samples},
      {"hosts", figures.hosts},     {"idle_bytes_per_s", number(figures.idle_bytes_per_s)},
      {"subscribers", subscribers},
  };
}

std::string format_bytes(double bytes) {
  if (bytes < 1e3) return fmt::format("{:.0f} B", bytes);
  if (bytes < 1e6) return fmt::format("{:.2f} kB", bytes / 1e3);
  if (bytes < 1e9) return fmt::format("{:.2f} MB", bytes / 1e6);
  return fmt::format("{:.2f} GB", bytes / 1e9);
}

std::string format_count(std::uint64_t count) {
  std::string text = std::to_string(count);
  for (auto at = static_cast<std::ptrdiff_t>(text.size()) - 3; at > 0; at -= 3)
    text.insert(static_cast<std::size_t>(at), ",");
  return text;
}

std::string format_fields(const SubscriberFigures& subscriber) {
  if (subscriber.fields.empty()) return "none";
  if (subscriber.other_fields.empty()) return "all";
  if (subscriber.fields.size() <= subscriber.other_fields.size())
    return fmt::format("{}", fmt::join(subscriber.fields, ", "));
  return fmt::format("all but {}", fmt::join(subscriber.other_fields, ", "));
}

}  // namespace sft::demo
