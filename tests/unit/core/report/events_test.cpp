// Events are derived from the difference between two states.
#include "core/report/events.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <sensor_msgs/msg/PointCloud2.hpp>

namespace sft::core {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

using sensor_msgs::msg::PointCloud2;

constexpr std::uint64_t peer = 7;

PublisherStatus serving(const PublisherStatus::Reader& reader) {
  PublisherStatus status;
  status.readers = {reader};
  return status;
}
SubscriberStatus hearing(const SubscriberStatus::Writer& writer) {
  SubscriberStatus status;
  status.writers = {writer};
  return status;
}

PublisherStatus::Reader reader(bool served, TransportKind transport = TransportKind::udp,
                               std::string reason = "so") {
  return {.id = peer, .node = "n", .served = served, .transport = transport, .reason = std::move(reason)};
}
SubscriberStatus::Writer writer(bool matched, std::string reason = "so") {
  return {.id = peer, .node = "n", .matched = matched, .reason = std::move(reason)};
}

std::vector<Event::Kind> kinds(const std::vector<Event>& events) {
  std::vector<Event::Kind> k;
  for (const Event& event : events) k.push_back(event.kind);
  return k;
}

std::vector<Event> between(const PublisherStatus& before, const PublisherStatus& after) {
  return events_between(before, after, type_support<PointCloud2>());
}
std::vector<Event> between(const SubscriberStatus& before, const SubscriberStatus& after) {
  return events_between(before, after, type_support<PointCloud2>());
}

TEST(EventsTest, NothingHappensBetweenEqualStates) {
  EXPECT_THAT(between(serving(reader(true)), serving(reader(true))), IsEmpty());
  EXPECT_THAT(between(hearing(writer(true)), hearing(writer(true))), IsEmpty());
}

TEST(EventsTest, SamplesThatSharedMemoryDoesNotTakeAreToldOfByReason) {
  PublisherStatus before, after;
  before.diverted = {.exhausted = 3, .too_large = 1};
  after.diverted = {.exhausted = 5, .too_large = 1, .unavailable = 1};
  const std::vector<Event> events = between(before, after);
  EXPECT_THAT(kinds(events), ElementsAre(Event::Kind::samples_diverted, Event::Kind::samples_diverted));
  EXPECT_EQ(events[0].count, 2U);
  EXPECT_NE(events[0].text, events[1].text);
}

TEST(EventsTest, SamplesThatAreTooLargeForSharedMemoryAreToldOfWithBothSizesAndACure) {
  PublisherStatus before, after;
  after.diverted = {.too_large = 1, .too_large_bytes = 6'000'000, .chunk_bytes = 1'000'000};
  const std::vector<Event> events = between(before, after);
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(
      events[0].text,
      "by UDP within the host: a sample of 6000000 bytes is larger than the largest chunk of shared "
      "memory, which has room for 1000000; enlarge /dev/shm, or set total_mib or [[pool]] in sftd.toml");
}

TEST(EventsTest, ASubscriberIsToldThatItHoldsTooMany) {
  SubscriberStatus after;
  after.held_too_many = 1;
  EXPECT_THAT(kinds(between(SubscriberStatus{}, after)), ElementsAre(Event::Kind::held_too_many));
}

TEST(EventsTest, APeerIsMatchedWhenItIsServedAndNotBefore) {
  EXPECT_THAT(between(PublisherStatus{}, serving(reader(false))), IsEmpty());
  const auto events = between(serving(reader(false)), serving(reader(true)));
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(events[0], (Event{.kind = Event::Kind::matched, .peer = peer, .node = "n", .text = "udp: so"}));
}

TEST(EventsTest, APeerIsUnmatchedWhenItIsNotServedAnyMoreOrGone) {
  const auto silent = between(serving(reader(true)), serving(reader(false, {}, "no answer")));
  ASSERT_THAT(kinds(silent), ElementsAre(Event::Kind::unmatched));
  EXPECT_EQ(silent[0].text, "no answer");
  EXPECT_THAT(kinds(between(hearing(writer(true)), SubscriberStatus{})), ElementsAre(Event::Kind::unmatched));
  EXPECT_THAT(between(hearing(writer(false)), SubscriberStatus{}), IsEmpty());
}

TEST(EventsTest, AnotherPathIsToldWithItsReasonAndAnotherReasonAloneIsNot) {
  const auto before = serving(reader(true));
  const auto events = between(before, serving(reader(true, TransportKind::shm, "same host")));
  ASSERT_THAT(kinds(events), ElementsAre(Event::Kind::path_changed));
  EXPECT_EQ(events[0].text, "shm: same host");
  EXPECT_THAT(between(before, serving(reader(true, TransportKind::udp, "other words"))), IsEmpty());
}

TEST(EventsTest, IncompatiblePeersAreToldOnceOnBothSides) {
  PublisherStatus::Reader r = reader(false, {}, "words");
  r.incompatible_policy = QosPolicy::deadline;
  const auto events = between(PublisherStatus{}, serving(r));
  ASSERT_THAT(kinds(events), ElementsAre(Event::Kind::incompatible_qos));
  EXPECT_EQ(events[0].policy, QosPolicy::deadline);
  EXPECT_EQ(events[0].text, "words");
  EXPECT_THAT(between(serving(r), serving(r)), IsEmpty());
  SubscriberStatus::Writer w = writer(false);
  w.incompatible_type = true;
  EXPECT_THAT(kinds(between(SubscriberStatus{}, hearing(w))), ElementsAre(Event::Kind::incompatible_type));
}

TEST(EventsTest, PeersThatStayIncompatibleForAnotherReasonAreToldOnceMore) {
  PublisherStatus::Reader before = reader(false, {}, "words");
  before.incompatible_policy = QosPolicy::deadline;
  PublisherStatus::Reader other_words = before, other_policy = before;
  other_words.reason = "other words";
  other_policy.incompatible_policy = QosPolicy::liveliness;
  for (const auto& after : {other_words, other_policy}) {
    const auto events = between(serving(before), serving(after));
    ASSERT_THAT(kinds(events), ElementsAre(Event::Kind::incompatible_qos));
    EXPECT_EQ(events[0].text, after.reason);
    EXPECT_EQ(events[0].policy, after.incompatible_policy);
  }
}

TEST(EventsTest, APairWithoutAWayForSamplesIsToldOnceOnBothSides) {
  PublisherStatus::Reader r = reader(false, {}, "words");
  r.no_path = true;
  const auto events = between(serving(reader(false)), serving(r));
  ASSERT_THAT(kinds(events), ElementsAre(Event::Kind::no_path));
  EXPECT_EQ(events[0].text, "words");
  EXPECT_THAT(between(serving(r), serving(r)), IsEmpty());
  EXPECT_THAT(kinds(between(serving(r), serving(reader(true)))), ElementsAre(Event::Kind::matched));
  SubscriberStatus::Writer w = writer(false);
  w.no_path = true;
  EXPECT_THAT(kinds(between(SubscriberStatus{}, hearing(w))), ElementsAre(Event::Kind::no_path));
  SubscriberStatus::Writer yet = w;
  yet.no_path_yet = true;
  EXPECT_TRUE(between(SubscriberStatus{}, hearing(yet)).at(0).yet);
  EXPECT_FALSE(between(hearing(yet), hearing(w)).at(0).yet) << "by now there will never be one";
}

TEST(EventsTest, WhatASubscriberAsksForIsToldOnBothSidesWhenItChanges) {
  const auto& type = type_support<PointCloud2>();
  PublisherStatus::Reader before = reader(true);
  before.mask = type.parse_mask("height").value();
  PublisherStatus::Reader after = before;
  after.mask = type.parse_mask("height, width").value();
  after.max_rate_hz = 2.5;
  EXPECT_THAT(kinds(between(PublisherStatus{}, serving(before))), ElementsAre(Event::Kind::matched));
  const auto reported = between(serving(before), serving(after));
  ASSERT_THAT(kinds(reported), ElementsAre(Event::Kind::request_changed));
  EXPECT_EQ(reported[0].peer, peer);
  EXPECT_EQ(reported[0].text, "height, width, at most 2.5 Hz");
  SubscriberStatus recorded;
  recorded.mask = type.full();
  SubscriberStatus narrow;
  narrow.mask = type.none();
  EXPECT_THAT(between(SubscriberStatus{}, recorded), IsEmpty());
  const auto own = between(recorded, narrow);
  ASSERT_THAT(kinds(own), ElementsAre(Event::Kind::request_changed));
  EXPECT_EQ(own[0].peer, 0U);
  EXPECT_EQ(own[0].text, "no fields");
}

TEST(EventsTest, ARequestThatChangesInOneThingAloneIsAnEventOnBothSidesAndAnEqualOneIsNone) {
  const auto& type = type_support<PointCloud2>();
  const FieldMask height = type.parse_mask("height").value(), width = type.parse_mask("width").value();
  const auto event = [](const FieldMask& mask_before, double rate_before, const FieldMask& mask,
                        double rate) {
    PublisherStatus::Reader before = reader(true), after = before;
    before.mask = mask_before, before.max_rate_hz = rate_before, after.mask = mask, after.max_rate_hz = rate;
    SubscriberStatus own_before, own;
    own_before.mask = mask_before, own_before.max_rate_hz = rate_before, own.mask = mask,
    own.max_rate_hz = rate;
    const auto at_publisher = between(serving(before), serving(after)),
               at_subscriber = between(own_before, own);
    EXPECT_EQ(kinds(at_publisher), kinds(at_subscriber));
    return at_publisher.empty() ? std::string("nothing") : at_publisher[0].text;
  };
  EXPECT_EQ(event(height, 10, height, 10), "nothing");
  EXPECT_EQ(event(height, 10, width, 10), "width, at most 10 Hz");
  EXPECT_EQ(event(height, 10, height, 20), "height, at most 20 Hz");
  EXPECT_EQ(event(height, 10, height, 0), "height");
  EXPECT_EQ(event(height, 0, height, 10), "height, at most 10 Hz");
}

TEST(EventsTest, DeadlinesAndLivelinessAreToldOnBothSides) {
  PublisherStatus good;
  PublisherStatus late = good;
  late.deadlines_missed = 3;
  late.alive = false;
  const auto offered = between(good, late);
  ASSERT_THAT(kinds(offered), ElementsAre(Event::Kind::deadline_missed, Event::Kind::liveliness_lost));
  EXPECT_EQ(offered[0].count, 3U);
  EXPECT_EQ(offered[0].peer, 0U);
  EXPECT_THAT(kinds(between(late, good)), ElementsAre(Event::Kind::liveliness_recovered));

  SubscriberStatus::Writer silent = writer(true, "no sign of life");
  silent.deadlines_missed = 1;
  silent.alive = false;
  const auto requested = between(hearing(writer(true)), hearing(silent));
  ASSERT_THAT(kinds(requested), ElementsAre(Event::Kind::deadline_missed, Event::Kind::liveliness_lost));
  EXPECT_EQ(requested[1].text, "no sign of life");
  EXPECT_EQ(requested[1].peer, peer);
  EXPECT_THAT(kinds(between(hearing(silent), hearing(writer(true)))),
              ElementsAre(Event::Kind::liveliness_recovered));
}

TEST(EventsTest, LossesAreToldWithTheirNumber) {
  SubscriberStatus::Writer before = writer(true);
  before.lost = 2;
  SubscriberStatus::Writer after = before;
  after.lost = 5;
  const auto events = between(hearing(before), hearing(after));
  ASSERT_THAT(kinds(events), ElementsAre(Event::Kind::samples_lost));
  EXPECT_EQ(events[0].count, 3U);
}

/// A change of a status that already had counts, and the one event that the change causes.
template <class Status>
struct Change {
  Event::Kind kind;
  std::function<void(Status&)> before;
  std::function<void(Status&)> after;
  std::uint64_t count = 1;
};

template <class Status>
void expect_one_event_for_each(const Status& base, const std::vector<Change<Status>>& changes) {
  for (const Change<Status>& change : changes) {
    SCOPED_TRACE(to_string(change.kind));
    Status before = base;
    change.before(before);
    Status after = before;
    change.after(after);
    const std::vector<Event> events = between(before, after);
    EXPECT_THAT(kinds(events), ElementsAre(change.kind));
    EXPECT_EQ(events.empty() ? 0 : events[0].count, change.count);
    EXPECT_THAT(between(before, before), IsEmpty()) << "the event does not come before the change";
    EXPECT_THAT(between(after, after), IsEmpty()) << "the event comes only once";
  }
}

/// Returns the changes that publishers and subscribers report in the same way. `matches` is true while the
/// peer matches.
template <class Status, class Peer>
std::vector<Change<Status>> changes_of_peer(std::vector<Peer> Status::*peers, bool Peer::*matches,
                                            TransportKind other_path) {
  using Kind = Event::Kind;
  const auto set = [peers](auto member, auto value) {
    return [=](Status& status) { (status.*peers)[0].*member = value; };
  };
  const auto nothing = [](Status&) {};
  const auto unmatched = set(matches, false);
  return {{Kind::matched, unmatched, set(matches, true)},
          {Kind::unmatched, nothing, unmatched},
          {Kind::path_changed, nothing, set(&Peer::transport, other_path)},
          {Kind::incompatible_qos, unmatched, set(&Peer::incompatible_policy, QosPolicy::deadline)},
          {Kind::incompatible_type, unmatched, set(&Peer::incompatible_type, true)},
          {Kind::no_path, unmatched, set(&Peer::no_path, true)}};
}

TEST(EventsTest, EachKindComesOnceToAPublisherWithWhatHasBeenAddedSinceThen) {
  using S = PublisherStatus;
  using Kind = Event::Kind;
  S base = serving(reader(true));
  base.readers[0].mask = type_support<PointCloud2>().full();
  base.deadlines_missed = 3;
  base.diverted = {.exhausted = 3, .too_large = 4, .unavailable = 5};
  const auto nothing = [](S&) {};
  const auto silent = [](S& s) { s.alive = false; };
  expect_one_event_for_each(base, changes_of_peer(&S::readers, &S::Reader::served, TransportKind::shm));
  expect_one_event_for_each<S>(
      base, {{Kind::request_changed, nothing, [](S& s) { s.readers[0].max_rate_hz = 5; }},
             {Kind::deadline_missed, nothing, [](S& s) { s.deadlines_missed += 2; }, 2},
             {Kind::liveliness_lost, nothing, silent},
             {Kind::liveliness_recovered, silent, [](S& s) { s.alive = true; }},
             {Kind::samples_diverted, nothing, [](S& s) { s.diverted.exhausted += 2; }, 2},
             {Kind::samples_diverted, nothing, [](S& s) { s.diverted.too_large += 3; }, 3},
             {Kind::samples_diverted, nothing, [](S& s) { s.diverted.unavailable += 4; }, 4}});
}

TEST(EventsTest, EachKindComesOnceToASubscriberWithWhatHasBeenAddedSinceThen) {
  using S = SubscriberStatus;
  using Kind = Event::Kind;
  S base = hearing(writer(true));
  base.mask = type_support<PointCloud2>().full();
  base.held_too_many = 3;
  base.writers[0].deadlines_missed = 4;
  base.writers[0].lost = 5;
  const auto nothing = [](S&) {};
  const auto silent = [](S& s) { s.writers[0].alive = false; };
  expect_one_event_for_each(base, changes_of_peer(&S::writers, &S::Writer::matched, TransportKind::udp));
  expect_one_event_for_each<S>(
      base, {{Kind::request_changed, nothing, [](S& s) { s.max_rate_hz = 5; }},
             {Kind::deadline_missed, nothing, [](S& s) { s.writers[0].deadlines_missed += 2; }, 2},
             {Kind::liveliness_lost, nothing, silent},
             {Kind::liveliness_recovered, silent, [](S& s) { s.writers[0].alive = true; }},
             {Kind::samples_lost, nothing, [](S& s) { s.writers[0].lost += 3; }, 3},
             {Kind::held_too_many, nothing, [](S& s) { s.held_too_many += 4; }, 4}});
}

TEST(EventsTest, LossesOfAReliablePairNameThePathTheQueueAndWhatHelps) {
  SubscriberStatus::Writer before = writer(true);
  before.depth = 256;
  SubscriberStatus::Writer after = before;
  after.lost = 5;
  const auto events =
      events_between(hearing(before), hearing(after), type_support<PointCloud2>(), Reliability::reliable);
  ASSERT_THAT(kinds(events), ElementsAre(Event::Kind::samples_lost));
  EXPECT_TRUE(events[0].reliable);
  EXPECT_THAT(events[0].text, testing::StartsWith("5 lost by shm although reliability was requested"));
  EXPECT_THAT(events[0].text, testing::HasSubstr("holds 256 samples"));
  EXPECT_THAT(events[0].text, testing::HasSubstr("PublisherOptions::max_blocking"));
}

}  // namespace
}  // namespace sft::core
