#include "core/discovery/repeated_pulses.h"

#include <algorithm>
#include <set>
#include <tuple>
#include <utility>

#include "core/discovery/leases.h"

namespace sft::core {

namespace {

/// Who has been silent for longer may be missing.
constexpr std::chrono::milliseconds lately = silence_in(lease_default);

std::tuple<NodeId, LinkId, std::uint32_t> key_of(LinkId link, const Pulse& pulse) {
  return {pulse.node, link, pulse.participant};
}

/// Apart from the number of full signs.
bool says_the_same(const Pulse& a, const Pulse& b) {
  return a.digest_of_writers == b.digest_of_writers && a.digest_of_readers == b.digest_of_readers;
}

/// The first of all voices that has that key or a greater one.
template <class Voices, class Key>
auto place_of(Voices& voices, const Key& key) {
  return std::ranges::lower_bound(
      voices, key, {}, [](const auto& known) { return key_of(known.voice.speaker.link, known.voice.pulse); });
}

/// Null if it is not known.
template <class Voices>
auto find(Voices& voices, LinkId link, const Pulse& pulse) -> decltype(voices.data()) {
  const auto place = place_of(voices, key_of(link, pulse));
  const bool is_known =
      place != voices.end() && key_of(place->voice.speaker.link, place->voice.pulse) == key_of(link, pulse);
  return is_known ? &*place : nullptr;
}

template <class Known>
void tell_one(Known& known, HearingWatch& hearing, LinkMerge& merge) {
  if (!std::exchange(known.waits, false)) return;
  const auto& [speaker, pulse, digest] = known.voice;
  hearing.heard_pulse(speaker, pulse, digest, known.since, known.last);
  merge.pulses_came_until(speaker, pulse.node, known.last);
}

}  // namespace

void RepeatedPulses::told(const Voice& voice, Time since, Time now) {
  const auto key = key_of(voice.speaker.link, voice.pulse);
  auto place = place_of(voices_, key);
  if (place == voices_.end() || key_of(place->voice.speaker.link, place->voice.pulse) != key) {
    if (voices_.size() >= voices_max) return;
    place = voices_.emplace(place);
  }
  *place = {.voice = voice, .since = since, .last = now};
}

void RepeatedPulses::begin(std::size_t living, std::size_t speakers, Time now) {
  std::erase_if(voices_, [&](const Known& known) { return now - known.last > lately; });
  std::set<Speaker> speaking;
  for (const Known& known : voices_) speaking.insert(known.voice.speaker);
  is_steady_ = voices_.size() == living && speaking.size() == speakers;
}

bool RepeatedPulses::waits(LinkId link, const Pulse& pulse, Time since, Time now) {
  if (!is_steady_) return false;
  Known* const known = find(voices_, link, pulse);
  if (known == nullptr || !says_the_same(known->voice.pulse, pulse)) return false;
  const bool tells_of_full_sign = known->voice.pulse.full_signs != pulse.full_signs;
  if (tells_of_full_sign && !std::exchange(known->full_sign_came, false)) return false;
  known->voice.pulse = pulse;
  known->since = since;
  known->last = now;
  known->waits = true;
  return true;
}

bool RepeatedPulses::is_as_before(LinkId link, const Pulse& pulse) const {
  if (!is_steady_) return false;
  const Known* const known = find(voices_, link, pulse);
  return known != nullptr && says_the_same(known->voice.pulse, pulse);
}

bool RepeatedPulses::full_sign_is_as_before(const Speaker& speaker, NodeId node, std::uint32_t digest) {
  if (!is_steady_) return false;
  const auto place = place_of(voices_, std::tuple(node, speaker.link, std::uint32_t{0}));
  if (place == voices_.end() || place->voice.pulse.node != node) return false;
  place->full_sign_came = true;
  return place->voice.speaker == speaker && place->voice.digest == digest;
}

bool RepeatedPulses::need_no_look(Time now) const {
  return is_steady_ && now - looked_at_ < waits_max &&
         std::ranges::all_of(voices_, [now](const Known& known) { return now - known.last <= lately; });
}

void RepeatedPulses::tell(HearingWatch& hearing, LinkMerge& merge) {
  for (Known& known : voices_) tell_one(known, hearing, merge);
}

void RepeatedPulses::make_way(NodeId node, bool is_as_before, HearingWatch& hearing, LinkMerge& merge) {
  if (!is_steady_) return;
  if (!is_as_before) return end(hearing, merge);
  for (auto known = place_of(voices_, std::tuple(node, LinkId{0}, std::uint32_t{0}));
       known != voices_.end() && known->voice.pulse.node == node; ++known)
    tell_one(*known, hearing, merge);
}

void RepeatedPulses::end(HearingWatch& hearing, LinkMerge& merge) {
  tell(hearing, merge);
  voices_.clear();
  is_steady_ = false;
}

}  // namespace sft::core
