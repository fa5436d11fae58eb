#include "core/node/control_monitor.h"

#include <utility>

#include "core/control/names.h"

namespace sft::core {

namespace {
constexpr std::chrono::seconds log_refusals_every{60};
constexpr std::size_t refusals_named_max = 10;
}  // namespace

void ControlMonitor::log_refusals(Time now) {
  for (const auto& [node, times] : negotiation_.take_refusals()) {
    if (refusals_.size() < refusals_named_max || refusals_.contains(node)) refusals_[node] += times;
  }
  if (refusals_.empty() || now < log_refusals_at_) return;
  log_refusals_at_ = now + log_refusals_every;
  std::string text;
  for (const auto& [node, times] : std::exchange(refusals_, {}))
    text += (text.empty() ? "" : ", ") + std::to_string(times) + " of node " + in_quotes(node);
  log_.write(LogLevel::warning, "the table of endpoints has no room for all that is announced; refused: " +
                                    text + "; NodeStatus::control_ignored counts them");
}

void ControlMonitor::name_misspelt_topics(const MisspeltTopics::PublishersOf& publishers_of, Time now) {
  for (const std::string& sentence : misspelt_topics_.look(negotiation_.table(), publishers_of, now))
    log_.write(LogLevel::warning, sentence);
}

}  // namespace sft::core
