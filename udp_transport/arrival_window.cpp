#include "udp_transport/arrival_window.h"

#include <algorithm>
#include <utility>

namespace sft::udp {

namespace {
constexpr std::chrono::milliseconds delay_longest{100};
}

std::optional<ArrivalWindow::Mark> ArrivalWindow::mark() const {
  if (!channel_) return {};
  return Mark{*channel_, std::max(end_, skip_to_) - base_};
}

void ArrivalWindow::join(const Mark& left) {
  channel_ = left.channel;
  slots_.begin_at(left.end);
  next_ = end_ = skip_to_ = left.end;
  for (Reader& reader : readers_) reader.place = left.end;
  joining_ = true;
}

void ArrivalWindow::begin_with(Place place) {
  joining_ = false;
  if (place < next_ || !slots_.empty()) return;
  slots_.begin_at(place);
  next_ = end_ = skip_to_ = place;
}

/// False for a channel of before. What is missing of that one will not come any more. And where places would
/// not fit into their type: only lies bring it there.
bool ArrivalWindow::turn_to(std::uint32_t channel) {
  if (channel_ == channel) return true;
  if (channel_ && static_cast<std::int32_t>(channel - *channel_) < 0) return false;
  if (end_ > ordinal_max) return false;
  channel_ = channel;
  joining_ = false;
  lose_before(end_);
  base_ = end_ - 1;  // its first ordinal is 1
  return true;
}

ArrivalWindow::Met ArrivalWindow::meet(const ChannelMark& mark, Time now) {
  if (!turn_to(mark.channel)) return {Standing::beyond, 0};
  heard_at_ = now;
  const Place place = base_ + mark.ordinal;
  if (place < slots_.begin()) return {Standing::known, 0};
  if (joining_) begin_with(place);
  if (place - slots_.begin() >= limits_.samples) {
    overtakes_ = holds_back();
    return {Standing::beyond, 0};
  }
  if (!reach(place + 1, now) || !slots_.contains(place)) return {Standing::beyond, 0};
  const State state = slots_[place].state;
  if (state != State::missing) came_again(place);
  return {state == State::missing ? Standing::wanted : Standing::known, place};
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
  settle(slots_[place], State::passed);
  ++unacked_;
  advance();
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

/// What was never heard of before the first word of a writer was not for us.
void ArrivalWindow::lose_before(Place end) {
  for (Place place = next_; place < std::min(end, slots_.end()); ++place) {
    Slot& slot = slots_[place];
    if (slot.state != State::whole && slot.state != State::passed) lose(slot);
  }
  const Place unseen = std::max(slots_.end(), skip_to_);
  if (end > unseen && end_ > base_ + 1) lost_ += end - unseen;
  skip_to_ = std::max(skip_to_, end);
  advance();
}

void ArrivalWindow::hear(const Heartbeat& heartbeat, Time now) {
  if (!turn_to(heartbeat.channel)) return;
  heard_at_ = now;
  ack_wanted_ = true;
  if (joining_) begin_with(base_ + heartbeat.end);
  lose_before(base_ + heartbeat.first);
  reach(std::max(end_, base_ + heartbeat.end), now);
  if (next_ < slots_.end()) look_at(now + delay_);
  end_requests(base_ + heartbeat.end + heartbeat.waiting);
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
  return {
      .writer = writer, .channel = channel_.value_or(0), .next = std::max<Place>(acked_, base_ + 1) - base_};
}

}  // namespace sft::udp
