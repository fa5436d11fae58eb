#include "core/report/events.h"

#include <algorithm>

#include "core/platform/in_digits.h"

namespace sft {

const char* to_string(Event::Kind kind) {
  switch (kind) {
    case Event::Kind::matched:
      return "matched";
    case Event::Kind::unmatched:
      return "unmatched";
    case Event::Kind::path_changed:
      return "path changed";
    case Event::Kind::incompatible_qos:
      return "incompatible QoS";
    case Event::Kind::incompatible_type:
      return "incompatible type";
    case Event::Kind::no_path:
      return "no path";
    case Event::Kind::deadline_missed:
      return "deadline missed";
    case Event::Kind::liveliness_lost:
      return "liveliness lost";
    case Event::Kind::liveliness_recovered:
      return "liveliness recovered";
    case Event::Kind::samples_lost:
      return "samples lost";
    case Event::Kind::samples_diverted:
      return "samples diverted";
    case Event::Kind::held_too_many:
      return "too many samples held";
    case Event::Kind::request_changed:
      return "request changed";
  }
  return "unknown";
}

namespace core {

namespace {

using Reader = PublisherStatus::Reader;
using Writer = SubscriberStatus::Writer;
using Diverted = PublisherStatus::Diverted;

// The status of a reader and that of a writer differ here only in the name of a member: a reader is
// `served`, a writer is `matched`.
bool matched(const Reader& reader) { return reader.served; }
bool matched(const Writer& writer) { return writer.matched; }

template <class Peer>
Event event_of(Event::Kind kind, const Peer& peer, std::string text, std::uint64_t count = 1) {
  return {.kind = kind,
          .peer = peer.id,
          .node = peer.node,
          .policy = peer.incompatible_policy,
          .count = count,
          .text = std::move(text)};
}

template <class Peer>
std::string path_of(const Peer& peer) {
  return std::string(to_string(peer.transport)) + ": " + peer.reason;
}

/// Adds the events of one peer. `before` is an earlier state of the same peer, or an empty one.
template <class Peer>
void add_changes(const Peer& before, const Peer& after, std::vector<Event>& events) {
  if (matched(before) && !matched(after)) {
    events.push_back(event_of(Event::Kind::unmatched, after, after.reason));
  }
  if (after.incompatible_type && !before.incompatible_type) {
    events.push_back(event_of(Event::Kind::incompatible_type, after, after.reason));
  }
  if (after.incompatible_policy != QosPolicy::none &&
      (before.incompatible_policy != after.incompatible_policy || before.reason != after.reason)) {
    events.push_back(event_of(Event::Kind::incompatible_qos, after, after.reason));
  }
  if (after.no_path && (!before.no_path || before.no_path_yet != after.no_path_yet)) {
    events.push_back(event_of(Event::Kind::no_path, after, after.reason));
    events.back().yet = after.no_path_yet;
  }
  if (!matched(before) && matched(after)) {
    events.push_back(event_of(Event::Kind::matched, after, path_of(after)));
  } else if (matched(after) && before.transport != after.transport) {
    events.push_back(event_of(Event::Kind::path_changed, after, path_of(after)));
  }
}

/// Returns a request as text: "height, width, at most 10 Hz".
std::string request_text(const FieldMask& mask, double max_rate_hz, const TypeSupport& type) {
  std::string text = mask.empty() ? "no fields" : type.format_mask(mask);
  if (max_rate_hz == 0) return text;
  return text + ", at most " + in_digits(max_rate_hz) + " Hz";
}

/// Returns true if the request of a reader or of a subscriber has changed. If the earlier mask has no
/// leaves, there was no request yet.
template <class Asking>
bool request_changed(const Asking& before, const Asking& after) {
  if (before.mask.leaves() == 0 || after.mask.leaves() == 0) return false;
  return before.mask != after.mask || before.max_rate_hz != after.max_rate_hz;
}

template <class Peer>
const Peer* find(const std::vector<Peer>& peers, std::uint64_t id) {
  const auto found = std::find_if(peers.begin(), peers.end(), [&](const Peer& p) { return p.id == id; });
  return found == peers.end() ? nullptr : &*found;
}

/// Calls `changed(before, after)` for each present peer, and adds events for peers that have departed.
template <class Peer, class Changed>
void compare(const std::vector<Peer>& before, const std::vector<Peer>& after, std::vector<Event>& events,
             Changed changed) {
  for (const Peer& gone : before) {
    if (matched(gone) && find(after, gone.id) == nullptr) {
      events.push_back(event_of(Event::Kind::unmatched, gone, "the other side has left"));
    }
  }
  for (const Peer& peer : after) {
    const Peer* known = find(before, peer.id);
    changed(known == nullptr ? Peer{} : *known, peer);
  }
}

void add_promises(const Writer& before, const Writer& after, std::vector<Event>& events) {
  if (after.deadlines_missed > before.deadlines_missed) {
    const std::uint64_t missed = after.deadlines_missed - before.deadlines_missed;
    events.push_back(
        event_of(Event::Kind::deadline_missed, after, "no sample within the requested deadline", missed));
  }
  if (before.alive == after.alive) return;
  events.push_back(event_of(after.alive ? Event::Kind::liveliness_recovered : Event::Kind::liveliness_lost,
                            after, after.alive ? "it gives signs of life again" : after.reason));
}

void add_promises(const PublisherStatus& before, const PublisherStatus& after, std::vector<Event>& events) {
  if (after.deadlines_missed > before.deadlines_missed) {
    events.push_back({.kind = Event::Kind::deadline_missed,
                      .count = after.deadlines_missed - before.deadlines_missed,
                      .text = "nothing was published within the offered deadline"});
  }
  if (before.alive && !after.alive) {
    events.push_back(
        {.kind = Event::Kind::liveliness_lost, .text = "liveliness was not asserted within the lease"});
  } else if (after.alive && !before.alive) {
    events.push_back({.kind = Event::Kind::liveliness_recovered, .text = "liveliness is asserted again"});
  }
}

void add_diverted(const Diverted& before, const Diverted& after, std::vector<Event>& events) {
  const auto add = [&](std::uint64_t Diverted::*count, const std::string& why) {
    if (after.*count == before.*count) return;
    events.push_back({.kind = Event::Kind::samples_diverted,
                      .count = after.*count - before.*count,
                      .text = "by UDP within the host: " + why});
  };
  const std::string cure = "; enlarge /dev/shm, or set total_mib or [[pool]] in sftd.toml";
  add(&Diverted::exhausted, "no chunk of that size is free in shared memory" + cure);
  add(&Diverted::too_large,
      "a sample of " + std::to_string(after.too_large_bytes) +
          " bytes is larger than the largest chunk of shared memory, which has room for " +
          std::to_string(after.chunk_bytes) + cure);
  add(&Diverted::unavailable, "shared memory is unavailable at the moment");
}

/// Returns a text about samples that were lost although the subscriber requested reliability, with a
/// remedy.
std::string reliable_loss_text(const Writer& writer, std::uint64_t lost) {
  const bool in_memory = writer.transport == TransportKind::shm;
  return std::to_string(lost) + " lost by " + to_string(writer.transport) +
         " although reliability was requested: " +
         (in_memory ? "its queue holds " : "the publisher keeps only so many for it, and its queue holds ") +
         std::to_string(writer.depth) + " samples; take them sooner, raise SubscriberOptions::depth" +
         (in_memory ? " (up to what shared memory keeps)" : "") +
         ", or let the publisher wait (PublisherOptions::max_blocking)";
}

void add_counts(const Writer& before, const Writer& after, Reliability reliability,
                std::vector<Event>& events) {
  if (after.lost <= before.lost) return;
  const std::uint64_t lost = after.lost - before.lost;
  const bool reliable = reliability == Reliability::reliable;
  events.push_back(event_of(Event::Kind::samples_lost, after,
                            reliable ? reliable_loss_text(after, lost) : std::to_string(lost) + " lost",
                            lost));
  events.back().reliable = reliable;
}

}  // namespace

std::vector<Event> events_between(const PublisherStatus& before, const PublisherStatus& after,
                                  const TypeSupport& type) {
  std::vector<Event> events;
  compare(before.readers, after.readers, events, [&](const Reader& b, const Reader& a) {
    add_changes(b, a, events);
    if (!request_changed(b, a)) return;
    events.push_back(event_of(Event::Kind::request_changed, a, request_text(a.mask, a.max_rate_hz, type)));
  });
  add_promises(before, after, events);
  add_diverted(before.diverted, after.diverted, events);
  return events;
}

std::vector<Event> events_between(const SubscriberStatus& before, const SubscriberStatus& after,
                                  const TypeSupport& type, Reliability reliability) {
  std::vector<Event> events;
  if (request_changed(before, after)) {
    events.push_back(
        {.kind = Event::Kind::request_changed, .text = request_text(after.mask, after.max_rate_hz, type)});
  }
  if (after.held_too_many > before.held_too_many) {
    events.push_back({.kind = Event::Kind::held_too_many,
                      .count = after.held_too_many - before.held_too_many,
                      .text = "no more of a publisher can be taken until samples of it are destroyed"});
  }
  compare(before.writers, after.writers, events, [&](const Writer& b, const Writer& a) {
    add_changes(b, a, events);
    add_promises(b, a, events);
    add_counts(b, a, reliability, events);
  });
  return events;
}

}  // namespace core
}  // namespace sft
