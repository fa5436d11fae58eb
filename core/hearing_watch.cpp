#include "core/hearing_watch.h"

#include <algorithm>

namespace sft::core {

namespace {

using std::chrono::milliseconds;

/// Cyclone notices the end of a lease by itself, but on a thread that may have to wait for a processor.
constexpr milliseconds slack_of_leases{300};
constexpr milliseconds confirmed_after{400};
/// If two looks are further apart, then this process itself was held up.
constexpr milliseconds look_pause_max{1200};
/// Announcements are repeated until they are acknowledged, but while many nodes start they take their time.
constexpr milliseconds behind_after{2500}, behind_at_first_after{5000};
/// So many links are tried for a participant whose digest never agreed: something else may be wrong with it.
constexpr unsigned tries_max = 3;
/// A participant that leaves withdraws its endpoints first, and then itself, within that time.
constexpr milliseconds leaving{1500};
/// A participant that is there says something within that time, unless many nodes start.
constexpr milliseconds first_word_after{8000};
/// A speaker counts as heard on a link for so long after it was. Signs of life come more often.
constexpr milliseconds heard_lately{2500};

}  // namespace

void HearingWatch::link_dropped(LinkId link) {
  links_.erase(link);
  std::erase_if(ears_, [&](const auto& entry) { return entry.first.link == link; });
  std::erase_if(participants_, [&](const auto& participant) {
    return std::ranges::none_of(ears_,
                                [&](const auto& ear) { return ear.first.participant == participant.first; });
  });
}

bool HearingWatch::is_replaced_by(LinkId before, LinkId after, Now now) const {
  return std::ranges::all_of(ears_, [&](const auto& entry) {
    const auto& [speaker, ear] = entry;
    if (speaker.link != before || !ear.has_spoken || now - ear.last > heard_lately) return true;
    const auto there = ears_.find({after, speaker.participant});
    return there != ears_.end() && there->second.has_spoken;
  });
}

void HearingWatch::endpoint_matched(const Speaker& speaker) {
  const auto ear = ears_.find(speaker);
  if (ear != ears_.end() && ear->second.unmatched > 0) --ear->second.unmatched;
}

void HearingWatch::endpoint_unmatched(const Speaker& speaker, Now now) {
  const auto ear = ears_.find(speaker);
  if (ear == ears_.end()) return;
  ++ear->second.unmatched;
  ear->second.unmatched_at = now;
}

HearingWatch::Ear* HearingWatch::ear_of(const Speaker& speaker, Now now) {
  if (!links_.contains(speaker.link)) return nullptr;
  const auto known = ears_.find(speaker);
  if (known != ears_.end()) return &known->second;
  if (ears_.size() >= speakers_max) return nullptr;
  return &ears_.emplace(speaker, Ear{.last = now, .agreed = now}).first->second;
}

void HearingWatch::participant_came(const Speaker& speaker, bool speaks, Now now) {
  if (const auto link = links_.find(speaker.link); link != links_.end()) link->second.newcomer = now;
  if (speaks) (void)ear_of(speaker, now);
}

void HearingWatch::participant_left(const Speaker& speaker) {
  ears_.erase(speaker);
  participants_.erase(speaker.participant);
}

void HearingWatch::heard(const Speaker& speaker, Now now) {
  Ear* const ear = ear_of(speaker, now);
  if (ear == nullptr) return;
  ear->last = now;
  ear->has_spoken = true;
}

void HearingWatch::heard_life(const Speaker& speaker, NodeId node, std::uint32_t digest, milliseconds lease,
                              Now now) {
  heard(speaker, now);
  Ear* const ear = ear_of(speaker, now);
  if (ear == nullptr) return;
  ear->node = node;
  ear->lives = true;
  ear->last_life = now;
  ear->lease = lease;
  ear->told = digest;
  if (ear->told == ear->known) {
    ear->agreed = now;
    ear->has_agreed = true;
    participants_[speaker.participant] = {.has_agreed = true, .tries = 0};
  }
  ear->overdue_since.reset();
}

void HearingWatch::life_ended(LinkId link, NodeId node) {
  for (auto& [speaker, ear] : ears_) {
    if (speaker.link == link && ear.node == node) ear.lives = false;
  }
}

std::vector<HearingWatch::Deaf> HearingWatch::look(const std::map<Speaker, std::uint32_t>& known,
                                                   milliseconds participant_lease, Now now) {
  const bool was_held_up = now - looked_ > look_pause_max;
  looked_ = now;
  std::vector<Deaf> deaf;
  for (auto& [speaker, ear] : ears_) {
    if (was_held_up) ear.overdue_since.reset();
    const auto digest = known.find(speaker);
    const std::uint32_t known_now = digest == known.end() ? 0 : digest->second;
    if (known_now != ear.known || known_now == ear.told) ear.agreed = now;
    ear.known = known_now;
    if (links_.at(speaker.link).is_replaced) continue;
    const auto what = missing(speaker, ear, participant_lease, now);
    if (what && (deaf.empty() || deaf.back().link != speaker.link))
      deaf.push_back({speaker.link, speaker.participant, ear.node, *what});
  }
  return deaf;
}

std::optional<HearingWatch::Missing> HearingWatch::missing(const Speaker& speaker, Ear& ear,
                                                           milliseconds participant_lease, Now now) const {
  const auto known = participants_.find(speaker.participant);
  const bool is_hopeless =
      known != participants_.end() && !known->second.has_agreed && known->second.tries >= tries_max;
  if (is_hopeless) return {};
  const Now newcomer = links_.at(speaker.link).newcomer;
  const bool is_mute = !ear.has_spoken && now - std::max(ear.last, newcomer) > first_word_after;
  if (is_mute || now - ear.last > participant_lease * 3 / 2) return Missing::everything;
  if (ear.unmatched > 0 && now - ear.unmatched_at > leaving) return Missing::endpoints;
  if (!ear.lives) return {};
  if (now - ear.last_life > ear.lease + slack_of_leases) {
    if (!ear.overdue_since) ear.overdue_since = now;
    if (now - *ear.overdue_since >= confirmed_after) return Missing::signs_of_life;
    return {};
  }
  const Now calm_since = std::max(ear.agreed, newcomer);
  const bool is_heard = now - ear.last_life < ear.lease / 2;
  const milliseconds patience = ear.has_agreed ? behind_after : behind_at_first_after;
  if (is_heard && now - calm_since > patience) return Missing::announcements;
  return {};
}

}  // namespace sft::core
