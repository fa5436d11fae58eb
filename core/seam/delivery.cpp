#include "core/seam/delivery.h"

#include <algorithm>

namespace sft::core {

namespace {

using Reading = DeliveryMeter::Reading;

void add(Delivered& sum, const Delivered& more) noexcept {
  using D = Delivered;
  for (const auto count :
       {&D::sent, &D::withheld, &D::dropped, &D::retained, &D::diverted, &D::bytes, &D::bytes_saved})
    sum.*count += more.*count;
}

constexpr std::uint64_t Reading::*counts[] = {&Reading::sent,
                                              &Reading::dropped,
                                              &Reading::bytes,
                                              &Reading::whole_bytes,
                                              &Reading::lost,
                                              &Reading::lost_bytes,
                                              &Reading::lost_whole_bytes,
                                              &Reading::withheld,
                                              &Reading::diverted};

}  // namespace

Reading& Reading::operator+=(const Reading& other) noexcept {
  for (const auto count : counts) this->*count += other.*count;
  return *this;
}

Reading& Reading::operator-=(const Reading& other) noexcept {
  for (const auto count : counts) this->*count -= other.*count;
  return *this;
}

/// Returns the reading as counts of one reader. The losses of the queue may include samples that were sent
/// to other readers before this reader joined. So no more losses count for this reader than samples were
/// sent to it.
Delivered Reading::delivered() const noexcept {
  Delivered d;
  const std::uint64_t lost_of_ours = std::min(lost, sent);
  const std::uint64_t whole_bytes_sent = whole_bytes - std::min(lost_whole_bytes, whole_bytes);
  d.sent = sent - lost_of_ours;
  d.dropped = dropped + lost_of_ours;
  d.withheld = withheld;
  d.diverted = diverted - std::min(lost_of_ours, diverted);
  d.bytes = bytes - std::min(lost_bytes, bytes);
  d.bytes_saved = whole_bytes_sent - std::min(d.bytes, whole_bytes_sent);
  return d;
}

Reading DeliveryMeter::read() const noexcept {
  constexpr auto relaxed = std::memory_order_relaxed;
  Reading r;
  if (losses != nullptr) {
    r.lost = losses->lost_.load(relaxed);
    r.lost_bytes = losses->bytes_.load(relaxed);
    r.lost_whole_bytes = losses->whole_bytes_.load(relaxed);
  }
  if (tally != nullptr) {
    r.sent = tally->sent_.load(relaxed);
    r.dropped = tally->dropped_.load(relaxed);
    r.bytes = tally->bytes_.load(relaxed);
    r.whole_bytes = tally->whole_bytes_.load(relaxed);
    if (diverted) r.diverted = r.sent;
  }
  if (gate != nullptr) r.withheld = gate->withheld();
  return r;
}

Reading DeliveryBook::Counts::sum() const noexcept {
  Reading sum = meter.read();
  sum -= at_first;
  sum += late.read();
  sum -= at_last;
  return sum += before;
}

void DeliveryBook::Counts::close(LateCounts late_counts) noexcept {
  const Reading now = meter.read();
  before += now;
  before -= at_first;
  before += late.read();
  before -= at_last;
  late = {};
  at_last = {};
  if (late_counts == LateCounts::to_come && meter.tally != nullptr) {
    late.tally = meter.tally;
    late.diverted = meter.diverted;
    at_last = {.sent = now.sent,
               .dropped = now.dropped,
               .bytes = now.bytes,
               .whole_bytes = now.whole_bytes,
               .diverted = now.diverted};
  }
  at_first = {};
  meter = {};
}

bool DeliveryBook::Account::open() const noexcept {
  return std::any_of(std::begin(columns), std::end(columns), [](const Counts& column) {
    return column.meter.tally != nullptr || column.meter.gate != nullptr;
  });
}

Delivered DeliveryBook::Account::delivered() const noexcept {
  Delivered delivered;
  for (const Counts& column : columns) add(delivered, column.sum().delivered());
  delivered.retained = retained;
  return delivered;
}

void DeliveryBook::enter(const Page& page) {
  const Lock lock(mutex_);
  for (const auto& [reader, meter] : page) accounts_.try_emplace(reader);
}

void DeliveryBook::retained(std::uint64_t reader, std::uint64_t samples) {
  const Lock lock(mutex_);
  accounts_[reader].retained += samples;
}

void DeliveryBook::keep(const std::set<std::uint64_t>& readers) {
  const Lock lock(mutex_);
  for (auto& [reader, account] : accounts_) account.gone = !readers.contains(reader);
  forget_the_gone();
}

/// Moves the counts of departed readers to the total. Readers on the pages in use are left out, because
/// their counts may grow until the next page is put into use.
void DeliveryBook::forget_the_gone() {
  for (auto entry = accounts_.begin(); entry != accounts_.end();) {
    const Account& account = entry->second;
    if (account.gone && !account.open()) {
      add(gone_, account.delivered());
      entry = accounts_.erase(entry);
    } else {
      ++entry;
    }
  }
}

void DeliveryBook::turn_to(Origin origin, const Page& page, LateCounts late) noexcept {
  const auto number = static_cast<std::size_t>(origin);
  const Lock lock(mutex_);
  for (auto& [reader, account] : accounts_) account.columns[number].close(late);
  for (const auto& [reader, meter] : page) {
    const auto account = accounts_.find(reader);
    if (account == accounts_.end()) continue;
    Counts& column = account->second.columns[number];
    column.meter = meter;
    column.at_first = meter.read();
  }
}

Delivered DeliveryBook::of(std::uint64_t reader) const {
  const Lock lock(mutex_);
  const auto account = accounts_.find(reader);
  return account == accounts_.end() ? Delivered{} : account->second.delivered();
}

Delivered DeliveryBook::total() const {
  const Lock lock(mutex_);
  Delivered total = gone_;
  for (const auto& [reader, account] : accounts_) add(total, account.delivered());
  return total;
}

}  // namespace sft::core
