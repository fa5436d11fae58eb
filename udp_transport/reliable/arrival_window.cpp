#include "udp_transport/reliable/arrival_window.h"

#include <algorithm>
#include <utility>

namespace sft::udp {

std::optional<ArrivalWindow::Mark> ArrivalWindow::mark() const {
  if (!channels_.present()) return {};
  return Mark{*channels_.present(), ordinal_of(samples_.end())};
}

void ArrivalWindow::join(const Mark& left) {
  channels_.turn(left.channel, 0);
  fresh_ = false;
  begin_with(left.end);
  readers_.begin_at(left.end);
  joining_ = true;
}

void ArrivalWindow::begin_with(Place place) {
  joining_ = false;
  if (samples_.begin_with(place)) reported_end_.begin(ordinal_of(place));
}

/// Evaluates the channel of a datagram, and changes to that channel if necessary. Returns false if the
/// datagram has to be ignored. After a change, missing samples of the previous channel will not come any
/// more.
bool ArrivalWindow::turn_to(const ChannelMonitor::Observed& observed, Time now) {
  switch (channels_.evaluate(observed, now)) {
    case ChannelMonitor::Verdict::present:
      return true;
    case ChannelMonitor::Verdict::ignore:
      return false;
    case ChannelMonitor::Verdict::turn:
      break;
  }
  const std::uint64_t begin = channels_.turn(observed.channel, ordinal_of(samples_.next()));
  joining_ = false;
  ordinals_ = {};
  begin_channel(begin);
  reported_end_.begin(begin);
  fresh_ = begin == 1;
  return true;
}

/// Continues with that ordinal of the present channel. It gets the place after the last known one.
void ArrivalWindow::begin_channel(std::uint64_t ordinal) {
  samples_.lose_before(samples_.end(), !fresh_);
  places_.begin(ordinal, samples_.end());
}

/// Goes back to that ordinal. Called if this ordinal and greater ones were wrongly skipped.
void ArrivalWindow::go_back_to(std::uint64_t ordinal) {
  begin_channel(ordinal);
  ordinals_.go_on_with(ordinal);
  reported_end_.go_back_to(ordinal);
  pending_ack_.want();
}

ArrivalWindow::Met ArrivalWindow::meet(const ChannelMark& mark, Time now, bool same_datagram) {
  using State = ArrivedSamples::State;
  const auto channel = mark.in_short ? channels_.widen(mark.channel, whole_channels_end) : mark.channel;
  if (!channel) return {Standing::beyond, 0};  // a heartbeat will name the channel with its full number
  if (!turn_to({*channel, mark.ordinal, mark.ordinal, same_datagram}, now)) return {Standing::beyond, 0};
  samples_.schedule().heard(now);
  const Place place = places_.place_of(mark.ordinal);
  if (!places_.follows(mark.ordinal) || place < samples_.slots().begin())
    return meet_passed_over(mark, now, same_datagram);
  if (joining_) begin_with(place);
  if (place - samples_.slots().begin() >= limits_.samples) {
    const bool is_known_of = place <= samples_.end();
    if (!is_known_of && !ordinals_.confirmed(mark.ordinal, same_datagram, now)) return {Standing::beyond, 0};
    overtakes_ = holds_back();
    ask_for_next(now);
    return {Standing::beyond, 0};
  }
  if (!samples_.reach(place + 1, now) || !samples_.slots().contains(place)) return {Standing::beyond, 0};
  const State state = samples_.slots()[place].state;
  if (state == State::passed) return meet_passed_over(mark, now, same_datagram);
  if (state == State::begun) samples_.look_at(samples_.schedule().soon(now));
  if (state != State::missing) {
    samples_.came_again(place);
    return {Standing::known, place};
  }
  fresh_ = false;
  ordinals_.advanced();
  reported_end_.agrees();
  return {Standing::wanted, place};
}

ArrivalWindow::Met ArrivalWindow::meet_passed_over(const ChannelMark& mark, Time now, bool same_datagram) {
  const Place place = places_.place_of(mark.ordinal);
  const bool has_slot = places_.follows(mark.ordinal) && samples_.slots().contains(place);
  if (has_slot) samples_.came_again(place);
  const auto back = ordinals_.passed_over(mark.ordinal, same_datagram, now);
  if (!back) return {Standing::known, has_slot ? place : 0};
  go_back_to(*back);
  return meet(mark, now, same_datagram);
}

/// Requests the next sample from a writer that is far ahead, although the writer may not have that sample
/// any more. The writer's answer shows which samples it still has.
void ArrivalWindow::ask_for_next(Time now) {
  if (!fresh_) samples_.reach(samples_.next() + 1, now);
  pending_ack_.want();
}

void ArrivalWindow::whole(Place place, core::SampleHandle sample) {
  const std::size_t bytes = sample->header().body_bytes;
  const bool readers_lag = holds_back();
  if (!samples_.whole(place, std::move(sample))) return;
  ordinals_.came(ordinal_of(place));
  pending_ack_.came(bytes);
  if (readers_lag) {
    overtakes_ = overtakes_ || samples_.held_bytes() > limits_.awaited_bytes;
  } else {
    samples_.hold_no_more_than_allowed();
  }
}

void ArrivalWindow::pass(Place place) {
  if (!samples_.slots().contains(place)) return;
  ordinals_.came(ordinal_of(place));
  samples_.pass(place);
  pending_ack_.came(0);
}

void ArrivalWindow::refuse_or_pass(Place place) {
  if (samples_.makes_no_sense_again(place)) return pass(place);
  samples_.refuse(place);
}

void ArrivalWindow::hear(const Heartbeat& heartbeat, Time now) {
  if (heartbeat.end - heartbeat.first > kept_max || heartbeat.waiting > kept_max) return;
  if (!turn_to({heartbeat.channel, heartbeat.first, heartbeat.end}, now)) return;
  const Time heard_before = samples_.schedule().heard_at();
  samples_.schedule().heard(now);
  pending_ack_.want();
  if (joining_) begin_with(places_.place_of(heartbeat.end));
  if (contradicts(heartbeat, now)) go_back_to(heartbeat.first);
  if (was_never_published(heartbeat, now)) go_back_to(heartbeat.end + heartbeat.waiting);
  if (!follow(heartbeat, heard_before, now)) return ask_for_next(now);
  fresh_ = false;
  const Place end = places_.place_of(heartbeat.end);
  samples_.forget_unpublished(end + heartbeat.waiting, now);
  samples_.reach(std::max(samples_.end(), std::min(end, samples_.first_wanted() + kept_max)), now);
  if (samples_.next() < samples_.slots().end()) samples_.look_at(samples_.schedule().soon(now));
  readers_.end_requests(end + heartbeat.waiting);
}

/// Counts samples that the writer no longer has as lost. Returns false if the heartbeat is too far ahead to
/// be credible. Samples before the first heartbeat of a writer do not count, since they were not for this
/// process.
bool ArrivalWindow::follow(const Heartbeat& heartbeat, Time heard_before, Time now) {
  constexpr double sent_per_s_max = 1 << 22;
  const std::uint64_t known_end = ordinal_of(samples_.end());
  const std::uint64_t ahead = heartbeat.first - std::min(heartbeat.first, known_end);
  if (!fresh_ && ahead > kept_max) {
    if (!ordinals_.confirmed(heartbeat.first, false, now)) return false;
    const double silent_s = std::chrono::duration<double>(now - heard_before).count();
    if (static_cast<double>(ahead) > (1 << 16) + silent_s * sent_per_s_max) {
      begin_channel(heartbeat.first);
      return true;
    }
  }
  samples_.lose_before(places_.place_of(heartbeat.first), !fresh_);
  return true;
}

/// Returns true if the window has skipped all samples that the heartbeat reports as sent, although some of
/// them have not arrived.
bool ArrivalWindow::contradicts(const Heartbeat& heartbeat, Time now) {
  if (fresh_ || !reported_end_.is_news(heartbeat)) return false;
  const Place next = samples_.next();
  return places_.place_of(heartbeat.end) <= next && heartbeat.end < ordinal_of(next) &&
         ordinals_.passed_over(heartbeat.end - 1, false, now).has_value();
}

/// Returns true if a sample arrived whose ordinal the writer has not published yet, so that the ordinal was
/// wrong. For this, the writer's heartbeats must have shown that for a while, and no new sample may have
/// arrived meanwhile. The caller then goes back, because the writer's next sample will have that ordinal.
bool ArrivalWindow::was_never_published(const Heartbeat& heartbeat, Time now) {
  const std::uint64_t end = heartbeat.end + heartbeat.waiting;
  if (!fresh_ && end < ordinal_of(samples_.next()) && places_.follows(end))
    return reported_end_.insists_on(end, now);
  reported_end_.agrees();
  return false;
}

void ArrivalWindow::release() {
  const Place taken = readers_.first_not_taken(samples_.next());
  if (samples_.slots().begin() < taken) overtakes_ = false;
  pending_ack_.taken(taken);
  samples_.release_before(taken);
  if (!holds_back()) samples_.hold_no_more_than_allowed();
  if (samples_.slots().end() < samples_.end()) samples_.reach(samples_.end(), samples_.schedule().heard_at());
}

Ack ArrivalWindow::ack(std::uint32_t writer) {
  const Place next = samples_.next();
  const Place acked = awaited_ ? readers_.first_not_taken(next) : next;
  pending_ack_.sent(acked, next);
  return {.writer = writer,
          .channel = channels_.present().value_or(0),
          .next = ordinal_of(std::max(acked, places_.first()))};
}

}  // namespace sft::udp
