// A fixture for tests of Peers: another process, with a participant on each of its links.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <tuple>
#include <vector>

#include "core/discovery/peers.h"

namespace sft::core {

inline constexpr LinkId cable = 1, wlan = 2, new_cable = 3;
inline constexpr ProcessId own_process = 64, neighbour = 7;

class PeersTest : public ::testing::Test {
 protected:
  PeersTest() {
    peers.listen(Role::writer, now);
    peers.link_made(cable, now);
    peers.link_made(wlan, now);
    now += std::chrono::seconds(10);
  }

  static RemoteParticipant on(LinkId link, std::uint8_t number = 0) {
    return {link, {number == 0 ? static_cast<std::uint8_t>(link) : number}};
  }
  static RecordBody body(const std::string& text) {
    const auto* const first = reinterpret_cast<const std::byte*>(text.data());
    return std::make_shared<const std::vector<std::byte>>(first, first + text.size());
  }
  void found(LinkId link) { peers.participant_found(on(link), neighbour, now); }
  /// The process writes a record, which arrives by the links `by`.
  void writes(std::uint32_t slot, const std::string& text, const std::vector<LinkId>& by) {
    const Record record{++revision, text.empty() ? nullptr : body(text)};
    own.put({slot, {}}, record);
    for (const LinkId link : by) peers.record_came(on(link), Role::writer, {slot, {}}, record, now);
  }
  /// Another process writes a record in the name of this process's participant on that link.
  void forges(LinkId link, std::uint32_t slot, const std::string& text, std::uint64_t as_revision = 1000) {
    peers.record_came(on(link), Role::writer, {slot, {}}, {as_revision, body(text)}, now);
  }
  void heartbeats(const std::vector<LinkId>& by) {
    for (const LinkId link : by)
      peers.heartbeat_came(link, {on(link).guid, neighbour, {own.digest(), 0}}, now);
    look();
  }
  /// For the duration `time` the process continues to send heartbeats on the links `by`.
  void goes_on(Time::duration time, const std::vector<LinkId>& by) {
    for (const Time end = now + time; now < end;) {
      now += std::chrono::milliseconds(500);
      heartbeats(by);
    }
  }
  void look() {
    peers.look(now);
    for (const PeerAction& action : peers.take_actions()) {
      if (std::holds_alternative<PeerLost>(action)) ++losses, holds.clear();
      if (const auto* const record = std::get_if<RecordChanged>(&action)) note(*record);
      if (const auto* const cut = std::get_if<PathsCut>(&action)) cut_links = cut->links;
      if (const auto* const of_link = std::get_if<LinkAction>(&action)) note(*of_link);
    }
  }
  void note(const LinkAction& action) {
    using Kind = LinkAction::Kind;
    if (action.kind == Kind::renew) renew(action.link);
    if (action.kind == Kind::use_topic) unheard.push_back(action.link);
    if (action.kind == Kind::announce || action.kind == Kind::ask)
      announced.emplace_back(now - began_at, action.link, action.kind == Kind::ask);
  }
  void renew(LinkId link) {
    renewed.push_back(link);
    peers.link_made(++last_link, now);
    peers.link_replaced(link, last_link, now);
  }
  void note(const RecordChanged& changed) {
    if (changed.record.is_withdrawn()) {
      holds.erase(changed.key.slot);
      return;
    }
    const auto* const text = reinterpret_cast<const char*>(changed.record.body->data());
    holds[changed.key.slot] = std::string(text, changed.record.body->size());
  }
  /// The process is found on both links, and all its records arrive by both.
  void meet_on_both_links() {
    found(cable);
    found(wlan);
    writes(0, "a", {cable, wlan});
    heartbeats({cable, wlan});
    goes_on(std::chrono::seconds(10), {cable, wlan});
    ASSERT_THAT(holds, ::testing::ElementsAre(::testing::Pair(0, "a")));
  }

  const Timing timing;
  Time now = Time(std::chrono::seconds(100));
  Time began_at = now;
  Peers peers{own_process, timing};
  Records own;
  LinkId last_link = wlan;
  std::uint64_t revision = 0;
  std::map<std::uint32_t, std::string> holds;
  int losses = 0;
  /// When this process announced itself after `began_at`, on which link, and whether it asked others to.
  std::vector<std::tuple<Time::duration, LinkId, bool>> announced;
  std::vector<LinkId> renewed, cut_links, unheard;
};

}  // namespace sft::core
