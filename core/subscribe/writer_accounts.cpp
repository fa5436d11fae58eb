#include "core/subscribe/writer_accounts.h"

#include <algorithm>

#include "core/seam/gate.h"

namespace sft::core {

namespace {
constexpr std::size_t departed_writers_kept = 64;  // their last samples may still be taken
}  // namespace

WriterAccounts::Writer& WriterAccounts::open(EndpointId writer) {
  Writer& added = writers_.emplace_back();
  added.id = writer;
  added.sequences.ask(min_period_us_);
  return added;
}

const WriterAccounts::Writer* WriterAccounts::find(EndpointId writer) const {
  const auto known = std::ranges::find(writers_, writer, &Writer::id);
  return known == writers_.end() ? nullptr : &*known;
}

void WriterAccounts::ask(std::uint32_t min_period_us) {
  min_period_us_ = min_period_us;
  ask_all();
}

void WriterAccounts::ask_conditions(std::uint64_t hash) {
  conditions_ = hash;
  ask_all();
}

void WriterAccounts::ask_all() {
  for (Writer& writer : writers_) writer.sequences.ask(min_period_us_);
  asked_gates_.ask(gate_id(conditions_, min_period_us_), min_period_us_ != 0);
}

void WriterAccounts::hears(const std::vector<Hearing>& hearing, std::int64_t now_ns) {
  heard_.clear();
  for (const Hearing& h : hearing) {
    heard_.push_back(h.status);
    Writer& writer = of(h.source.writer);
    if (writer.since_ns == 0) writer.since_ns = now_ns;
    writer.lifespan_ns = h.offered.lifespan.count();
    // If samples expire, it is unknown how many of the retained samples can still arrive.
    if (writer.lifespan_ns == 0) writer.sequences.owe(h.owed);
  }
  if (writers_.size() > heard_.size() + departed_writers_kept) forget_departed();
}

bool WriterAccounts::is_heard(const Writer& writer) const {
  return std::ranges::find(heard_, writer.id, &SubscriberStatus::Writer::id) != heard_.end();
}

template <class Sum>
void WriterAccounts::add(Sum& sum, const Writer& writer) {
  sum.received += writer.received;
  sum.lost += writer.lost;
  sum.withheld += writer.withheld;
  sum.expired += writer.expired;
  sum.restarts += writer.restarts;
}

/// Removes the accounts of departed writers. A writer gets a new random id each time that it is opened. So a
/// removed id returns only if the node of the writer was silent for a long time.
void WriterAccounts::forget_departed() {
  std::erase_if(writers_, [this](const Writer& writer) {
    if (is_heard(writer)) return false;
    add(forgotten_, writer);
    return true;
  });
}

void WriterAccounts::lose_entered(EndpointId writer, std::uint64_t lost_before) {
  Writer& from = of(writer);
  ++from.lost;
  ++losses_;
  from.lost_untold += lost_before + 1;
}

bool WriterAccounts::keeps_promises(EndpointId writer, std::uint64_t more_missed, bool alive) {
  Writer& from = of(writer);
  const bool is_news = more_missed != 0 || from.alive != alive;
  from.deadlines_missed += more_missed;
  from.alive = alive;
  return is_news;
}

void WriterAccounts::describe(SubscriberStatus& status) const {
  status.max_rate_hz = min_period_us_ == 0 ? 0 : 1e6 / min_period_us_;
  status.writers = heard_;
  add(status, forgotten_);
  for (const Writer& writer : writers_) {
    add(status, writer);
    for (SubscriberStatus::Writer& heard : status.writers) {
      if (heard.id == writer.id) fill_in(heard, writer);
    }
  }
}

void WriterAccounts::fill_in(SubscriberStatus::Writer& status, const Writer& writer) {
  status.received = writer.received;
  status.lost = writer.lost;
  status.withheld = writer.withheld;
  status.expired = writer.expired;
  status.deadlines_missed = writer.deadlines_missed;
  status.restarts = writer.restarts;
  if (writer.alive || !status.alive) return;
  status.alive = false;
  status.reason = "no sign of life within its lease";
}

}  // namespace sft::core
