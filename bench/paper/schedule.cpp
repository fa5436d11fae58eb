#include "bench/paper/schedule.h"

#include <fmt/format.h>

namespace sft::bench::paper {

std::string check(const Pace& pace, std::size_t contenders) {
  constexpr double slot_s_min = 0.001;
  const double rate_max = 1 / (slot_s_min * static_cast<double>(contenders));
  if (pace.rate_hz <= rate_max) return {};
  return fmt::format("{} contenders take turns: the rate may be {:.0f} Hz at most", contenders, rate_max);
}

std::int64_t Schedule::learning_ns(std::size_t number, std::size_t slot) const {
  return begin_ns_ + static_cast<std::int64_t>(number) * period_ns() + slot_ns(slot);
}

std::int64_t Schedule::due_ns(std::size_t phase, std::size_t number, std::size_t slot) const {
  const std::int64_t gap = number < pace_.settling ? 0 : gap_ns;
  return begin_ns(phase) + gap + static_cast<std::int64_t>(number) * period_ns() + slot_ns(slot);
}

std::int64_t Schedule::before_ns(std::size_t phase) const {
  return due_ns(phase, pace_.settling, 0) - gap_ns / 4;
}

std::int64_t Schedule::after_ns(std::size_t phase) const { return begin_ns(phase + 1) - gap_ns / 4; }

std::int64_t Schedule::slot_ns(std::size_t slot) const {
  return static_cast<std::int64_t>(slot) * (period_ns() / static_cast<std::int64_t>(contenders_));
}

std::int64_t Schedule::begin_ns(std::size_t phase) const {
  const auto messages = static_cast<std::int64_t>(pace_.settling + pace_.samples);
  return learning_ns(pace_.learning, 0) + static_cast<std::int64_t>(pace_.settled_s * 1e9) +
         static_cast<std::int64_t>(phase) * (messages * period_ns() + 2 * gap_ns);
}

}  // namespace sft::bench::paper
