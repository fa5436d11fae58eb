#include "core/node/control_watch.h"

#include <utility>

#include "core/control/names.h"

namespace sft::core {

namespace {
constexpr std::chrono::milliseconds take_back_every{100};  // a forger cannot make us announce more often
constexpr std::chrono::seconds complain_every{1};
constexpr std::chrono::seconds tell_of_refusals_every{60};
constexpr std::size_t refusals_named_max = 10;
}  // namespace

std::vector<EndpointId> ControlWatch::take_contested(Time now) {
  for (auto& [id, how] : negotiation_.take_contested()) contested_.insert_or_assign(id, std::move(how));
  if (contested_.empty() || now < take_back_at_) return {};
  take_back_at_ = now + take_back_every;
  std::vector<EndpointId> ours;
  std::string how_first;
  for (auto& [id, how] : std::exchange(contested_, {})) {
    if (negotiation_.local(id) == nullptr) continue;
    if (ours.empty()) how_first = std::move(how);
    ours.push_back(id);
  }
  if (!ours.empty() && now >= complain_at_) {
    complain_at_ = now + complain_every;
    complain(ours.front(), how_first, ours.size() - 1);
  }
  return ours;
}

void ControlWatch::complain(EndpointId ours, const std::string& how, std::size_t others) {
  const Endpoint& endpoint = *negotiation_.local(ours);
  std::string text = endpoint.role == Role::writer ? "our publisher of topic " : "our subscriber of topic ";
  text += in_quotes(endpoint.topic) + " " + how;
  if (others > 0) text += ", as are " + std::to_string(others) + " more of our endpoints";
  log_.write(
      LogLevel::warning,
      text + "; it is announced anew, but a program on this network speaks for others: find and stop it");
}

void ControlWatch::tell_of_refusals(Time now) {
  for (const auto& [node, times] : negotiation_.take_refusals()) {
    if (refusals_.size() < refusals_named_max || refusals_.contains(node)) refusals_[node] += times;
  }
  if (refusals_.empty() || now < tell_of_refusals_at_) return;
  tell_of_refusals_at_ = now + tell_of_refusals_every;
  std::string text;
  for (const auto& [node, times] : std::exchange(refusals_, {}))
    text += (text.empty() ? "" : ", ") + std::to_string(times) + " of node " + in_quotes(node);
  log_.write(LogLevel::warning, "the table of endpoints has no room for all that is announced; refused: " +
                                    text + "; NodeStatus::control_ignored counts them");
}

void ControlWatch::name_misspelt_topics(const MisspeltTopics::PublishersOf& publishers_of, Time now) {
  for (const std::string& sentence : misspelt_topics_.look(negotiation_.table(), publishers_of, now))
    log_.write(LogLevel::warning, sentence);
}

}  // namespace sft::core
