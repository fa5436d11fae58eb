// Events. Publishers and subscribers report them without being asked, so that a program need not poll
// status().
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "sft/qos.h"

namespace sft {

/// One event of a publisher or subscriber. It is a plain value, which callbacks may copy and keep.
struct Event {
  /// The kinds of events.
  enum class Kind : std::uint8_t {
    matched,            ///< the two endpoints match now; `text` says by which path, and why
    unmatched,          ///< the two endpoints do not match any more; `text` says why
    path_changed,       ///< samples are sent by another path now; `text` says by which one, and why
    incompatible_qos,   ///< `policy` is incompatible: the two endpoints will never match
    incompatible_type,  ///< the topics have the same name but different types: the two endpoints will never
                        ///< match
    no_path,            ///< type and QoS are compatible, but no path is allowed to both endpoints; `text`
                        ///< says why
    /// On a publisher: its own deadline was missed (`peer` is 0). On a subscriber: the deadline that it
    /// requested was missed.
    deadline_missed,
    /// On a publisher: its own liveliness was lost (`peer` is 0). On a subscriber: the liveliness of a
    /// publisher was lost.
    liveliness_lost,
    liveliness_recovered,  ///< the liveliness that `liveliness_lost` reported as lost was asserted again
    samples_lost,          ///< only on subscribers: `count` samples have not arrived
    /// Only on publishers: `count` samples were sent by UDP because shared memory could not take them.
    samples_diverted,
    held_too_many,  ///< only on subscribers: the program holds max_held samples, so that take() returns no
                    ///< more; `peer` is 0
    /// A subscriber requests other fields or another rate, which `text` contains. On the subscriber itself
    /// `peer` is 0.
    request_changed,
  };

  /// A callback for events. It runs on a thread of the node that handles only events and log lines. While
  /// the callback runs, other events and log lines of the node are queued, and nothing else is delayed. If
  /// 10,000 of them are queued, further ones are dropped, and the log says how many. No lock is held during
  /// the call, so the callback may call any function of SFT and destroy any object of SFT. The node's log
  /// gets the same events, even if there is no callback. If an event and its opposite follow each other
  /// closely, both may be omitted. After the destructor of the publisher or subscriber the callback is not
  /// called any more (unless the destructor runs within the callback itself).
  using Callback = std::function<void(const Event&)>;

  /// The kind of the event.
  Kind kind{};
  /// The id of the subscriber or publisher at the other end; 0: the event does not concern a particular
  /// one.
  std::uint64_t peer = 0;
  std::string node{};  ///< the name of the node of `peer`
  /// For incompatible_qos: the first incompatible policy.
  QosPolicy policy = QosPolicy::none;
  /// The number of missed deadlines, or of lost or diverted samples, since the last event of this kind.
  std::uint64_t count = 1;
  bool yet = false;       ///< for no_path: shared memory may still become available to either endpoint
  bool reliable = false;  ///< for samples_lost: true if the subscriber has requested reliability
  std::string text{};     ///< a sentence for people
  /// On a subscriber: the number of the selection that the event is about (SampleInfo::selection). Matches,
  /// paths and losses are reported for each selection.
  std::uint32_t selection = 0;
  friend bool operator==(const Event&, const Event&) = default;
};

/// Returns the name of the enumerator, which lives as long as the program.
const char* to_string(Event::Kind kind);

}  // namespace sft
