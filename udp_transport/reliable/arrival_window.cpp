#include "udp_transport/reliable/arrival_window.h"

#include <algorithm>
#include <utility>

namespace sft::udp {

namespace {
constexpr std::chrono::milliseconds delay_longest{100};
}

std::optional<ArrivalWindow::Mark> ArrivalWindow::mark() const {
  if (!channels_.present()) return {};
  return Mark{*channels_.present(), ordinal_of(std::max(end_, skip_to_))};
}

void ArrivalWindow::join(const Mark& left) {
  channels_.turn(left.channel, 0);
  fresh_ = false;
  slots_.begin_at(left.end);
  next_ = end_ = skip_to_ = left.end;
  not_told_before_ = left.end;
  for (Reader& reader : readers_) reader.place = left.end;
  joining_ = true;
}

void ArrivalWindow::begin_with(Place place) {
  joining_ = false;
  if (place < next_ || !slots_.empty()) return;
  slots_.begin_at(place);
  next_ = end_ = skip_to_ = place;
  not_told_before_ = ordinal_of(place);
}

/// False for a channel that does not count. What is missing of the one before will not come any more.
bool ArrivalWindow::turn_to(const ChannelWatch::Claim& claim, Time now) {
  switch (channels_.judge(claim, now)) {
    case ChannelWatch::Verdict::present:
      return true;
    case ChannelWatch::Verdict::ignore:
      return false;
    case ChannelWatch::Verdict::turn:
      break;
  }
  const std::uint64_t begin = channels_.turn(claim.channel, ordinal_of(next_));
  joining_ = false;
  ordinals_ = {};
  begin_channel(begin);
  not_told_before_ = begin;
  fresh_ = begin == 1;
  return true;
}

/// The present channel goes on with that ordinal: places count on.
void ArrivalWindow::begin_channel(std::uint64_t ordinal) {
  lose_before(end_);
  base_ = end_ - ordinal;
  first_ordinal_ = ordinal;
}

/// Goes back to that ordinal: it and those behind it were passed over, and should not have been.
void ArrivalWindow::go_back_to(std::uint64_t ordinal) {
  begin_channel(ordinal);
  ordinals_.go_on_with(ordinal);
  not_told_before_ = std::min(not_told_before_, ordinal);
  ack_wanted_ = true;
}

ArrivalWindow::Met ArrivalWindow::meet(const ChannelMark& mark, Time now, bool same_datagram) {
  const auto channel = mark.in_short ? channels_.widen(mark.channel, whole_numbers_end) : mark.channel;
  if (!channel) return {Standing::beyond, 0};  // a heartbeat will say which one it is
  if (!turn_to({*channel, mark.ordinal, mark.ordinal, same_datagram}, now)) return {Standing::beyond, 0};
  heard_at_ = now;
  Place place = place_of(mark.ordinal);
  if (mark.ordinal < first_ordinal_ || place < slots_.begin())
    return meet_passed_over(mark, now, same_datagram);
  if (joining_) begin_with(place);
  if (place - slots_.begin() >= limits_.samples) {
    if (place > end_ && !ordinals_.confirmed(mark.ordinal, same_datagram, now)) return {Standing::beyond, 0};
    overtakes_ = holds_back();
    ask_for_next(now);
    return {Standing::beyond, 0};
  }
  if (!reach(place + 1, now) || !slots_.contains(place)) return {Standing::beyond, 0};
  const State state = slots_[place].state;
  if (state == State::passed) return meet_passed_over(mark, now, same_datagram);
  if (state == State::begun) look_at(now + delay_);
  if (state != State::missing) came_again(place);
  if (state != State::missing) return {Standing::known, place};
  fresh_ = false;
  ordinals_.advanced();
  end_said_ = 0;
  return {Standing::wanted, place};
}

ArrivalWindow::Met ArrivalWindow::meet_passed_over(const ChannelMark& mark, Time now, bool same_datagram) {
  const Place place = place_of(mark.ordinal);
  const bool has_slot = mark.ordinal >= first_ordinal_ && slots_.contains(place);
  if (has_slot) came_again(place);
  const auto back = ordinals_.passed_over(mark.ordinal, same_datagram, now);
  if (!back) return {Standing::known, has_slot ? place : 0};
  go_back_to(*back);
  return meet(mark, now, same_datagram);
}

/// The writer is far ahead: it tells how far once it is asked for what it does not have any more.
void ArrivalWindow::ask_for_next(Time now) {
  if (!fresh_) reach(next_ + 1, now);
  ack_wanted_ = true;
}

/// Makes room for all places before `end`. False if that would be too many: those that fit are there then.
bool ArrivalWindow::reach(Place end, Time now) {
  end_ = std::max(end_, end);
  while (slots_.end() < end) {
    if (slots_.empty() && slots_.begin() < skip_to_) {
      slots_.begin_at(skip_to_);
      next_ = std::max(next_, skip_to_);
      continue;
    }
    if (slots_.size() >= limits_.samples) return false;
    const Time::duration apart = this->apart();
    Slot& slot = slots_.push_back({.ask_at = now + delay_ + apart, .apart = apart});
    if (slots_.end() <= skip_to_) settle(slot, State::passed);
    look_at(slot.ask_at);
  }
  advance();
  return true;
}

void ArrivalWindow::begun(Place place, const SampleLabel& label, core::SampleHandle buffer) {
  if (!slots_.contains(place)) return;
  Slot& slot = slots_[place];
  slot.state = State::begun;
  slot.label = label;
  slot.sample = std::move(buffer);
  slot.asked = 0;
  look_at(slot.ask_at);
}

void ArrivalWindow::whole(Place place, core::SampleHandle sample) {
  if (!slots_.contains(place)) return;
  const bool readers_lag = holds_back();
  Slot& slot = slots_[place];
  if (slot.state == State::passed) return;  // it was given up
  ordinals_.came(ordinal_of(place));
  held_bytes_ += sample->capacity;
  unacked_bytes_ += sample->header().body_bytes;
  ++unacked_;
  slot.sample = std::move(sample);
  settle(slot, State::whole);
  if (slot.parts > 0)  // it was asked for, and not too early
    delay_ = std::max<Time::duration>(limits_.ask_after, delay_ - delay_ / 8);
  advance();
  if (readers_lag) {
    overtakes_ = overtakes_ || held_bytes_ > limits_.awaited_bytes;
  } else {
    hold_no_more_than_allowed();
  }
}

void ArrivalWindow::pass(Place place) {
  if (!slots_.contains(place)) return;
  ordinals_.came(ordinal_of(place));
  settle(slots_[place], State::passed);
  ++unacked_;
  advance();
}

void ArrivalWindow::refuse(Place place) {
  if (!slots_.contains(place)) return;
  Slot& slot = slots_[place];
  if (slot.state != State::begun && slot.state != State::missing) return;
  slot.state = State::missing;
  slot.sample.reset();
  slot.ask_at = heard_at_ + delay_ + slot.apart;
  look_at(slot.ask_at);
}

void ArrivalWindow::refuse_or_pass(Place place) {
  if (!slots_.contains(place)) return;
  if (std::exchange(slots_[place].refused, true)) return pass(place);
  refuse(place);
}

/// Samples before the first missing one were acknowledged: they do not come again.
void ArrivalWindow::distrust_above(std::uint64_t sequence) {
  for (Place place = slots_.begin(); place < slots_.end(); ++place) {
    const Slot& slot = slots_[place];
    if (slot.state == State::whole && slot.sample->sequence > sequence) come_again(place);
  }
}

void ArrivalWindow::doubt(Place place, std::uint32_t sequence) {
  if (place < next_ || !slots_.contains(place) || slots_[place].state != State::whole) return;
  if (static_cast<std::uint32_t>(slots_[place].sample->sequence) != sequence) come_again(place);
}

/// The whole sample there was not the true one.
void ArrivalWindow::come_again(Place place) {
  Slot& slot = slots_[place];
  held_bytes_ -= slot.sample->capacity;
  if (place < next_) ready_bytes_ -= slot.sample->capacity;
  slot.state = place < next_ ? State::passed : State::missing;
  slot.sample.reset();
  slot.asked = 0;
  slot.ask_at = heard_at_ + delay_ + slot.apart;
  if (place >= next_) look_at(slot.ask_at);
}

std::optional<SampleLabel> ArrivalWindow::begun_at(Place place) const {
  if (place == 0 || !slots_.contains(place) || slots_[place].state != State::begun) return {};
  return slots_[place].label;
}

bool ArrivalWindow::is_stuck(Time head_came, Time now) {
  if (std::exchange(looked_at_next_, next_) != next_) next_since_ = now;
  const Time since = std::max(next_since_, head_came);
  return now - since >= limits_.claim_patience && heard_at_ - since >= limits_.claim_patience / 2;
}

void ArrivalWindow::give_back(Slot& slot, Time now) {
  given_back_.push_back(slot.label);
  slot.state = State::missing;
  slot.sample.reset();
  slot.asked = 0;
  slot.ask_at = now;
}

void ArrivalWindow::asked_for(Place place, std::uint32_t parts) {
  if (slots_.contains(place)) slots_[place].parts = std::max(parts, 1U);
}

/// If as much comes again as was asked for, then that was too early; less is what networks do.
void ArrivalWindow::came_again(Place place) {
  if (!slots_.contains(place)) return;
  Slot& slot = slots_[place];
  if (slot.parts == 0 || --slot.parts > 0) return;
  delay_ = std::min<Time::duration>(2 * delay_, delay_longest);
}

void ArrivalWindow::settle(Slot& slot, State state) {
  slot.state = state;
  if (state == State::passed) slot.sample.reset();
}

void ArrivalWindow::advance() {
  const auto settled = [](const Slot& slot) {
    return slot.state == State::whole || slot.state == State::passed;
  };
  next_ = std::max(next_, slots_.begin());
  for (; next_ < slots_.end() && settled(slots_[next_]); ++next_) {
    if (slots_[next_].state == State::whole) ready_bytes_ += slots_[next_].sample->capacity;
  }
  if (next_ == slots_.end()) look_at_ = Time::max();  // nothing is missing
}

void ArrivalWindow::lose(Slot& slot) {
  if (slot.state == State::begun) abandoned_.push_back(slot.label);
  settle(slot, State::passed);
  ++lost_;
}

/// Gives up the oldest that are missing where what is held back behind them is too much. What nothing is
/// missing before goes to the readers now.
void ArrivalWindow::hold_no_more_than_allowed() {
  while (held_bytes_ - ready_bytes_ > limits_.held_bytes) {
    lose(slots_[next_]);
    advance();
  }
}

/// Samples that were never heard of before the first word of a writer were not for us.
void ArrivalWindow::lose_before(Place end) {
  for (Place place = next_; place < std::min(end, slots_.end()); ++place) {
    Slot& slot = slots_[place];
    if (slot.state != State::whole && slot.state != State::passed) lose(slot);
  }
  const Place unseen = std::max(slots_.end(), skip_to_);
  if (end > unseen && !fresh_) lost_ += end - unseen;
  skip_to_ = std::max(skip_to_, end);
  end_ = std::max(end_, end);
  advance();
}

void ArrivalWindow::hear(const Heartbeat& heartbeat, Time now) {
  if (heartbeat.end - heartbeat.first > kept_max || heartbeat.waiting > kept_max) return;
  if (!turn_to({heartbeat.channel, heartbeat.first, heartbeat.end}, now)) return;
  const Time heard_before = std::exchange(heard_at_, now);
  ack_wanted_ = true;
  if (joining_) begin_with(place_of(heartbeat.end));
  if (contradicts(heartbeat, now)) go_back_to(heartbeat.first);
  if (was_never_published(heartbeat, now)) go_back_to(heartbeat.end + heartbeat.waiting);
  if (!follow(heartbeat, heard_before, now)) return ask_for_next(now);
  fresh_ = false;
  reach(std::max(end_, std::min(place_of(heartbeat.end), std::max(next_, skip_to_) + kept_max)), now);
  if (next_ < slots_.end()) look_at(now + delay_);
  end_requests(place_of(heartbeat.end) + heartbeat.waiting);
}

/// Counts samples that the writer no longer has as lost. Returns false if that is further ahead than is
/// believed.
bool ArrivalWindow::follow(const Heartbeat& heartbeat, Time heard_before, Time now) {
  constexpr double sent_per_s_max = 1 << 22;
  const std::uint64_t known_end = ordinal_of(std::max(end_, slots_.end()));
  const std::uint64_t ahead = heartbeat.first - std::min(heartbeat.first, known_end);
  if (!fresh_ && ahead > kept_max) {
    if (!ordinals_.confirmed(heartbeat.first, false, now)) return false;
    const double silent_s = std::chrono::duration<double>(now - heard_before).count();
    if (static_cast<double>(ahead) > (1 << 16) + silent_s * sent_per_s_max) {
      begin_channel(heartbeat.first);
      return true;
    }
  }
  lose_before(place_of(heartbeat.first));
  return true;
}

/// Returns true if everything that the writer has sent was passed over, and some of it has not arrived.
bool ArrivalWindow::contradicts(const Heartbeat& heartbeat, Time now) {
  if (heartbeat.end == heartbeat.first || heartbeat.end <= not_told_before_) return false;
  if (!fresh_ && place_of(heartbeat.end) <= next_ && heartbeat.end < ordinal_of(next_))
    return ordinals_.passed_over(heartbeat.end - 1, false, now).has_value();
  return false;
}

/// Returns true if something arrived that the writer has not published yet: the writer says so again after so
/// long, and nothing new has arrived meanwhile. The writer's next sample would take the place of that.
bool ArrivalWindow::was_never_published(const Heartbeat& heartbeat, Time now) {
  const std::uint64_t end = heartbeat.end + heartbeat.waiting;
  if (fresh_ || end >= ordinal_of(next_) || end < first_ordinal_) {
    end_said_ = 0;
    return false;
  }
  if (std::exchange(end_said_, end) == end) return now - end_said_since_ >= OrdinalWatch::doubted_after;
  end_said_since_ = now;
  return false;
}

void ArrivalWindow::set_readers(const std::vector<core::EndpointId>& readers) {
  const auto before = std::exchange(readers_, {});
  for (const core::EndpointId reader : readers) {
    const auto known = std::ranges::find(before, reader, &Reader::id);
    readers_.push_back(known == before.end() ? Reader{.id = reader, .place = next_} : *known);
  }
}

void ArrivalWindow::heard(core::EndpointId id, std::uint64_t request) {
  const auto reader = std::ranges::find(readers_, id, &Reader::id);
  if (reader != readers_.end()) reader->heard = std::max(reader->heard, request);
}

/// One after the other: each is waited for until it is reached.
void ArrivalWindow::end_requests(Place published) {
  for (Reader& reader : readers_) {
    reader.turn();
    if (reader.heard <= reader.request || reader.next_from != no_place) continue;
    reader.next_request = reader.heard;
    reader.next_from = published;
  }
}

ArrivalWindow::Place ArrivalWindow::first_not_taken() const {
  Place first = next_;
  for (const Reader& reader : readers_) first = std::min(first, reader.place);
  return first;
}

void ArrivalWindow::release() {
  const Place taken = first_not_taken();
  if (slots_.begin() < taken) overtakes_ = false;
  if (!acked_all_ && acked_ < taken) ack_wanted_ = true;
  while (!slots_.empty() && slots_.begin() < taken) {
    const Slot& slot = slots_[slots_.begin()];
    if (slot.state == State::whole) {
      held_bytes_ -= slot.sample->capacity;
      ready_bytes_ -= slot.sample->capacity;
    }
    slots_.pop_front();
  }
  if (!holds_back()) hold_no_more_than_allowed();
  if (slots_.end() < end_ || slots_.end() < skip_to_) reach(std::max(end_, skip_to_), heard_at_);
}

Ack ArrivalWindow::ack(std::uint32_t writer) {
  ack_wanted_ = false;
  unacked_bytes_ = 0;
  unacked_ = 0;
  acked_ = awaited_ ? first_not_taken() : next_;
  acked_all_ = acked_ == next_;
  return {.writer = writer,
          .channel = channels_.present().value_or(0),
          .next = ordinal_of(std::max(acked_, place_of(first_ordinal_)))};
}

}  // namespace sft::udp
