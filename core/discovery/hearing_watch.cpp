#include "core/discovery/hearing_watch.h"

#include <algorithm>
#include <utility>

#include "core/discovery/crowd.h"
#include "core/discovery/leases.h"

namespace sft::core {

namespace {

using std::chrono::milliseconds;

/// Cyclone notices the end of a lease by itself, but on a thread that may have to wait for a processor.
constexpr milliseconds slack_of_leases{300};
constexpr milliseconds confirmed_after{400};
/// A pulse that somebody else has sent is corrected by the next one before that time.
constexpr milliseconds confirmed_by_pulses_after{1500};
/// Full signs of life may get lost, but so many in a row hardly do.
constexpr std::uint8_t full_signs_missed_max = 8;
/// If two looks are further apart, then this process itself was held up.
constexpr milliseconds look_pause_max{1200};
/// Announcements are repeated until they are acknowledged, but while many nodes start they take their time.
constexpr milliseconds behind_after{1000}, behind_at_first_after{5000};
/// A replaced link lags if it has not heard for so long what the link in its place has heard.
constexpr milliseconds lags_after{300};
/// While nodes start, which takes so long, they may overtake each other by more.
constexpr milliseconds start_takes{2000};
/// What has to be waited for before somebody is doubted, or counts as behind, is longer where there are many
/// participants: what many announce at once takes its time, and would take more if all gave frequent signs.
/// Those that were never equal are still told everything, by many at a time.
constexpr milliseconds longer_for_each{20}, longer_at_first_for_each{60};
/// The number of links that are tried for a participant whose digest never agreed: something else may be
/// wrong with it.
constexpr unsigned tries_max = 3;
/// A participant that departs withdraws its endpoints first, and then itself, within that time.
constexpr milliseconds departing{1500};
/// A participant that is there says something within that time, unless many nodes start.
constexpr milliseconds first_word_after{8000};
/// Time for a complaint to arrive and for a link to be made anew. A complaint may get lost, and is repeated.
constexpr milliseconds complaint_patience{1500}, complaint_pause{400};
/// The average pause before a complaint grows by this for each other participant that may complain as well.
constexpr milliseconds complaint_spread{2};
/// A participant whose node has come anew is gone by then.
constexpr std::chrono::seconds goes_within{60};
constexpr milliseconds look_pause{920};  // with each tick in calm (tick_pace.h)
constexpr milliseconds look_pause_in_doubt{100}, look_pause_in_doubt_max{450};
/// A look in doubt costs more where there are more participants, and is as much rarer there.
constexpr milliseconds look_pause_for_each{5};

milliseconds pause_in_doubt(std::size_t participants) {
  return std::clamp<milliseconds>(look_pause_for_each * participants, look_pause_in_doubt,
                                  look_pause_in_doubt_max);
}

/// Something else is wrong with the participant than the links by which it is heard.
template <class Participants>
bool is_hopeless(const Participants& participants, AnnouncerId participant) {
  const auto known = participants.find(participant);
  return known != participants.end() && !known->second.has_agreed && known->second.tries >= tries_max;
}

/// True if a node of the speaker is heard as it should be by another participant on the link, since its
/// process has made its link anew, or we have.
bool speaks_otherwise(const std::map<Speaker, Ear>& ears, LinkId link, const Speaker& speaker, const Ear& ear,
                      Time now) {
  return std::ranges::any_of(ears, [&](const auto& entry) {
    const auto& [other, of_other] = entry;
    const auto has_too = [&](NodeId node) { return of_other.nodes.contains(node); };
    return other.link == link && other != speaker && of_other.is_well(now) &&
           ((ear.node != 0 && ear.node == of_other.node) || std::ranges::any_of(ear.nodes, has_too));
  });
}

bool is_behind(const Ear& ear, std::size_t ears, Time newcomer, Time now) {
  const milliseconds in_a_crowd =
      (ear.has_agreed ? longer_for_each : longer_at_first_for_each) * std::min(ears, crowd_max);
  if (!ear.lives || ear.known == ear.told) return false;
  if (ear.missed_since) return true;  // newcomers make no difference any more
  if (ear.is_contradicted && now - newcomer > start_takes + in_a_crowd) return true;
  const milliseconds patience = (ear.has_agreed ? behind_after : behind_at_first_after) + in_a_crowd;
  return ear.last_life - std::max(ear.agreed, newcomer) > patience;  // its signs of life still tell that
}

}  // namespace

void HearingWatch::link_dropped(LinkId link) {
  links_.erase(link);
  std::erase_if(ears_, [&](const auto& entry) { return entry.first.link == link; });
  std::erase_if(participants_, [&](const auto& participant) {
    return std::ranges::none_of(ears_,
                                [&](const auto& ear) { return ear.first.participant == participant.first; });
  });
}

bool HearingWatch::is_replaced_by(LinkId before, LinkId after, Time now) const {
  return std::ranges::all_of(ears_, [&](const auto& entry) {
    const auto& [speaker, ear] = entry;
    if (speaker.link != before || !ear.has_spoken || now - ear.last > Ear::heard_lately) return true;
    const auto there = ears_.find({after, speaker.participant});
    return there != ears_.end() && there->second.has_spoken;
  });
}

void HearingWatch::endpoint_matched(const Speaker& speaker, bool is_there, Time now) {
  if (is_there) met_at_ = now;
  const auto ear = ears_.find(speaker);
  if (ear == ears_.end()) return;
  int& unmatched = ear->second.unmatched;
  if (is_there) {
    unmatched = std::max(unmatched - 1, 0);
  } else {
    ++unmatched;
    ear->second.unmatched_at = now;
  }
}

Ear* HearingWatch::ear_of(const Speaker& speaker, Time now) {
  if (!links_.contains(speaker.link)) return nullptr;
  const auto known = ears_.find(speaker);
  if (known != ears_.end()) return &known->second;
  if (ears_.size() >= speakers_max) return nullptr;
  return &ears_.emplace(speaker, Ear{.last = now, .agreed = now}).first->second;
}

void HearingWatch::participant_came(const Speaker& speaker, Time now) {
  if (const auto link = links_.find(speaker.link); link != links_.end()) link->second.newcomer = now;
}

void HearingWatch::participant_departed(const Speaker& speaker) {
  ears_.erase(speaker);
  participants_.erase(speaker.participant);
}

void HearingWatch::hears_more(Time now) {
  for (auto& [id, link] : links_) link.newcomer = now;
  for (auto& [speaker, ear] : ears_) {
    ear.agreed = now;
    ear.has_agreed = false;
    ear.is_contradicted = false;
    ear.missed_since.reset();
  }
}

void HearingWatch::heard(const Speaker& speaker, Time now, std::optional<NodeId> announced) {
  Ear* const ear = ear_of(speaker, now);
  if (ear == nullptr) return;
  ear->last = now;
  ear->has_spoken = true;
  std::set<NodeId>& nodes = ear->signs.announced;
  if (announced && nodes.size() < Ear::nodes_max) nodes.insert(*announced);
  looks_often_ = true;
}

void HearingWatch::heard_life(const Speaker& speaker, NodeId node, std::uint32_t digest, milliseconds lease,
                              Time now) {
  Ear* const ear = ear_of(speaker, now);
  if (ear == nullptr) return;
  ear->has_spoken = true;
  ear->node = node;
  ear->lives = true;
  ear->signs.full_sign_came(node, lease, now);
  if (ear->lives_by(node, digest, now, now))
    participants_[speaker.participant] = {.has_agreed = true, .tries = 0};
}

bool HearingWatch::heard_pulse(const Speaker& speaker, const Pulse& pulse, std::uint32_t digest, Time since,
                               Time now) {
  const auto known = ears_.find(speaker);
  if (known == ears_.end()) return false;
  Ear& ear = known->second;
  if (ear.lives && ear.signs.named.contains(pulse.node)) {
    ear.signs.pulse_came(pulse, since, now);
  } else {
    if (links_.at(speaker.link).hears_full_signs) ear.signs.unnamed_pulse_came(pulse, now);
    if (!ear.signs.may_live(pulse.node)) return false;
    ear.lives = true;
  }
  if (ear.lives_by(pulse.node, digest, since, now))
    participants_[speaker.participant] = {.has_agreed = true, .tries = 0};
  return true;
}

void HearingWatch::life_ended(LinkId link, NodeId node) {
  for (auto& [speaker, ear] : ears_) {
    if (speaker.link != link) continue;
    ear.signs.named.erase(node);
    ear.signs.announced.erase(node);
    const bool is_its_node = ear.nodes.erase(node) > 0 || ear.node == node;
    if (is_its_node && ear.nodes.empty()) ear.lives = false;
  }
}

bool HearingWatch::wants_look(Time now) const {
  return now >= looked_ + (looks_often_ ? pause_in_doubt(ears_.size()) : look_pause);
}

Time HearingWatch::next_look_in_doubt() const {
  return looks_often_ ? looked_ + pause_in_doubt(ears_.size()) : Time::max();
}

std::vector<HearingWatch::Deaf> HearingWatch::look(const std::map<Speaker, std::uint32_t>& known,
                                                   milliseconds participant_lease, Time now) {
  note_known(known, now);
  looks_often_ = may_miss_something_ = false;
  const milliseconds longer = for_others(longer_for_each, ears_.size());
  const milliseconds longer_at_first = for_others(longer_at_first_for_each, ears_.size());
  std::vector<Deaf> deaf;
  for (auto& [speaker, ear] : ears_) {
    looks_often_ |= ear.lives && ear.known != ear.told && now - ear.agreed < behind_at_first_after;
    const bool is_doubtful = (ear.is_told_of_more() || ear.signs.misses_full_sign(longer_at_first, now)) &&
                             !is_hopeless(participants_, speaker.participant);
    looks_often_ |= is_doubtful;
    may_miss_something_ |= ear.is_doubtful_for(ear.has_agreed ? longer : longer_at_first, is_doubtful, now);
    const auto what = missing(speaker, ear, participant_lease, now);
    if (!what) {
      ear.missed_since.reset();
      continue;
    }
    looks_often_ = may_miss_something_ = true;
    const auto how = remedy(speaker, ear, *what, now);
    const bool is_told = how == Remedy::renewal && std::ranges::any_of(deaf, [&](const Deaf& other) {
                           return other.link == speaker.link && other.remedy == Remedy::renewal;
                         });
    if (how && !is_told) deaf.push_back({speaker.link, speaker.participant, ear.node, *what, *how});
  }
  return deaf;
}

bool HearingWatch::is_steady() const {
  const auto is_link_steady = [](const auto& entry) {
    return entry.second.hears_full_signs && !entry.second.replaced_by;
  };
  return !looks_often_ && !may_miss_something_ && std::ranges::all_of(links_, is_link_steady) &&
         std::ranges::all_of(ears_, [](const auto& entry) { return entry.second.is_steady(); });
}

std::set<NodeId> HearingWatch::nodes_known_whole(Time now) const {
  std::set<NodeId> nodes;
  for (const auto& [speaker, ear] : ears_) {
    if (ear.is_well(now)) nodes.insert(ear.nodes.begin(), ear.nodes.end());
  }
  return nodes;
}

void HearingWatch::note_known(const std::map<Speaker, std::uint32_t>& known, Time now) {
  const bool was_held_up = now - looked_ > look_pause_max;
  looked_ = now;
  for (auto& [speaker, ear] : ears_) {
    if (was_held_up) {
      ear.signs.overdue_since.reset();
      ear.is_contradicted = false;
    }
    const auto digest = known.find(speaker);
    const std::uint32_t known_now = digest == known.end() ? 0 : digest->second;
    if (known_now != ear.known) ear.changed = now;
    if (known_now != ear.known || known_now == ear.told) ear.agreed = now;
    if (known_now == ear.told) ear.is_contradicted = false;
    ear.known = known_now;
  }
}

/// A sign is late after the pause in calm, and a while in which its node may have waited for a processor. In
/// calm this is more than a look and less than two: of pulses two have got lost then.
bool HearingWatch::is_a_sign_late(Time now) const {
  return std::ranges::any_of(ears_, [now](const auto& entry) {
    const Ear& ear = entry.second;
    const bool is_pulse_late =
        ear.signs.last_pulse && now - *ear.signs.last_pulse > silence_in(lease_default) + slack_of_leases;
    const milliseconds lease = ear.signs.has_full_come() ? ear.signs.lease : lease_default;
    return ear.lives && (is_pulse_late || now - ear.last_life > silence_in(lease) + slack_of_leases);
  });
}

/// A participant that is not heard at all hears no complaint, either.
std::optional<HearingWatch::Remedy> HearingWatch::remedy(const Speaker& speaker, Ear& ear, Missing missing,
                                                         Time now) {
  if (ear.disbelieved_since && now - *ear.disbelieved_since < goes_within) return {};
  const LinkId link = links_.at(speaker.link).replaced_by.value_or(speaker.link);
  if (speaks_otherwise(ears_, link, speaker, ear, now)) {
    ear.disbelieved_since = now;
    return Remedy::disbelief;
  }
  if (links_.at(speaker.link).replaced_by) return {};
  if (missing == Missing::everything) return Remedy::renewal;
  const milliseconds spread = for_others(complaint_spread, ears_.size());
  if (!ear.missed_since) {
    ear.missed_since = now;
    ear.complain_at = now + milliseconds(random_() % static_cast<std::uint64_t>(2 * spread.count() + 1));
  }
  if (now - *ear.missed_since > complaint_patience + 2 * spread) return Remedy::renewal;
  if (now < ear.complain_at) return {};
  ear.complain_at = now + complaint_pause;
  return Remedy::complaint;
}

std::optional<HearingWatch::Missing> HearingWatch::missing(const Speaker& speaker, Ear& ear,
                                                           milliseconds participant_lease, Time now) const {
  if (is_hopeless(participants_, speaker.participant)) return {};
  const Link& link = links_.at(speaker.link);
  if (link.replaced_by) {
    const bool lags =
        ear.lives && ear.known != ear.told && (ear.is_contradicted || now - ear.agreed > lags_after);
    return lags ? std::optional(Missing::announcements) : std::nullopt;
  }
  const bool is_mute = !ear.has_spoken && now - std::max(ear.last, link.newcomer) > first_word_after;
  if (is_mute || now - ear.last > participant_lease * 3 / 2) return Missing::everything;
  if (ear.unmatched > 0 && now - ear.unmatched_at > departing) return Missing::endpoints;
  if (ear.signs.hears_no_full_sign(for_others(longer_at_first_for_each, ears_.size()), now))
    return Missing::signs_of_life;
  const bool is_over =
      ear.signs.has_full_come() && now - ear.signs.last_full > ear.signs.lease + slack_of_leases;
  if (ear.lives && (is_over || ear.signs.full_missed >= full_signs_missed_max)) {
    if (!ear.signs.overdue_since) ear.signs.overdue_since = now;
    if (now - *ear.signs.overdue_since >= (is_over ? confirmed_after : confirmed_by_pulses_after))
      return Missing::signs_of_life;
    return {};
  }
  ear.signs.overdue_since.reset();
  return is_behind(ear, ears_.size(), link.newcomer, now) ? std::optional(Missing::announcements)
                                                          : std::nullopt;
}

}  // namespace sft::core
