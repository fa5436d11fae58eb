#include "tools/demo/screen/figures.h"

#include <cmath>
#include <nlohmann/json.hpp>

namespace sft::demo {

namespace {

/// One decimal is enough: no figure is more exact than that. A figure that was not measured is null.
nlohmann::ordered_json number(double value, bool is_measured = true) {
  return is_measured ? nlohmann::ordered_json(std::round(value * 10) / 10) : nullptr;
}

std::vector<std::string> fields_of(const Route& route) {
  std::vector<std::string> fields;
  for (std::string text = route.fields.str(); !text.empty();) {
    const std::size_t end = text.find(", ");  // commas within a field have no blank behind them
    fields.push_back(text.substr(0, end));
    text = end == text.npos ? "" : text.substr(end + 2);
  }
  return fields;
}

nlohmann::ordered_json json_of(const SubscriberFigures& s, const RunFigures& run) {
  const bool is_measured = run.real_hosts();
  const bool any = s.counts.received > 0;
  return {
      {"name", s.name},
      {"transport", s.in_shared_memory() ? "shm" : "udp"},
      {"reason", s.route.reason.str()},
      {"fields", fields_of(s.route)},
      {"requirement", run.recorded ? "recorded" : "declared"},
      {"received", s.counts.received},
      {"lost", s.counts.lost},
      {"withheld", s.route.withheld},
      {"full_bytes_per_sample", number(run.whole_bytes)},
      {"wire_bytes_per_sample", number(s.sent_bytes(), is_measured && any)},
      {"learning_bytes", number(static_cast<double>(s.counts.learning_bytes), is_measured)},
      {"latency_us",
       {{"p50", number(s.counts.latency_p50_us, any)}, {"p99", number(s.counts.latency_p99_us, any)}}},
  };
}

}  // namespace

double SubscriberFigures::sent_bytes() const {
  return counts.steady_samples == 0
             ? 0
             : static_cast<double>(counts.steady_bytes) / static_cast<double>(counts.steady_samples);
}

double SubscriberFigures::saved(double whole_bytes) const {
  if (whole_bytes <= 0 || counts.received == 0) return 0;
  const double share =
      static_cast<double>(counts.received) / static_cast<double>(counts.received + route.withheld);
  return 1 - sent_bytes() * share / whole_bytes;
}

std::uint64_t RunFigures::lost() const {
  std::uint64_t sum = 0;
  for (const SubscriberFigures& s : subscribers) sum += s.counts.lost;
  return sum;
}

Carried RunFigures::carried() const {
  Carried sum;
  for (const SubscriberFigures& s : subscribers) {
    if (s.in_shared_memory()) continue;
    sum.bytes += static_cast<double>(s.counts.bytes);
    sum.whole_bytes += whole_bytes * static_cast<double>(samples);
  }
  return sum;
}

std::string to_json(const RunFigures& run) {
  nlohmann::ordered_json subscribers = nlohmann::ordered_json::array();
  for (const SubscriberFigures& s : run.subscribers) subscribers.push_back(json_of(s, run));
  const Carried carried = run.carried();
  const nlohmann::ordered_json json{
      {"input", run.input},
      {"samples", run.samples},
      {"hosts", run.hosts},
      {"carried_bytes", number(carried.bytes)},
      {"whole_bytes", number(carried.whole_bytes)},
      {"subscribers", subscribers},
  };
  return json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

}  // namespace sft::demo
