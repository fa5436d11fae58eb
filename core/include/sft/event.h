// Events. Publishers and subscribers report them without being asked, so that a program need not poll
// status().
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "sft/qos.h"

namespace sft {

/// One event of a publisher or subscriber. It is a value: callbacks may copy and keep it.
struct Event {
  /// The kinds of events.
  enum class Kind : std::uint8_t {
    matched,            ///< the two endpoints match; `text` says by which path, and why
    unmatched,          ///< the two endpoints do not match any more; `text` says why
    path_changed,       ///< samples take another path; `text` says which one, and why
    incompatible_qos,   ///< `policy` is incompatible: the two endpoints will never match
    incompatible_type,  ///< the topic has the same name but another type; the two will never match
    no_path,            ///< type and QoS fit, but no path is allowed to both; `text` says why there is none
    /// On a publisher: its own deadline was missed (`peer` is 0). On a subscriber: the deadline that it
    /// requested was missed.
    deadline_missed,
    /// On a publisher: its own liveliness was lost (`peer` is 0). On a subscriber: the liveliness of a
    /// publisher was lost.
    liveliness_lost,
    liveliness_recovered,  ///< as for `liveliness_lost`: the publisher is alive again
    samples_lost,          ///< only on subscribers: `count` samples did not arrive
    /// Only on publishers: `count` samples went by UDP because shared memory could not take them.
    samples_diverted,
    held_too_many,  ///< only on subscribers: the program holds max_held samples, so that take() returns no
                    ///< more; `peer` is 0
    /// A subscriber asks for other fields or another rate, which `text` names. On the subscriber itself
    /// `peer` is 0.
    request_changed,
  };

  /// A callback for events. It runs on a thread of the node that handles only events and log lines. While it
  /// runs, other events and log lines of the node wait, and nothing else does. If 10,000 of them wait,
  /// further ones are left out, and the log says how many. No lock is held during the call: the callback may
  /// call any function of SFT and destroy any object of SFT. The node's log gets the same events, whether
  /// there is a callback or not. If an event and its opposite follow each other closely, both may be left
  /// out. After the destructor of the publisher or subscriber the callback is not called any more (unless the
  /// destructor runs within the callback itself).
  using Callback = std::function<void(const Event&)>;

  /// The kind of the event.
  Kind kind{};
  /// The id of the subscriber or publisher at the other end; 0: the event concerns none.
  std::uint64_t peer = 0;
  std::string node{};  ///< the name of the node of `peer`
  /// For incompatible_qos: the first policy that does not fit.
  QosPolicy policy = QosPolicy::none;
  /// The number of missed deadlines, or of lost or diverted samples, since the last event of this kind.
  std::uint64_t count = 1;
  bool yet = false;       ///< for no_path: shared memory may still become available, on either side
  bool reliable = false;  ///< for samples_lost: the subscriber has asked for reliability
  std::string text{};     ///< a sentence for people
  /// On a subscriber: the number of the selection that the event is about (SampleInfo::selection). Matches,
  /// paths and losses are reported for each selection.
  std::uint32_t selection = 0;
  friend bool operator==(const Event&, const Event&) = default;
};

/// Returns the name of the enumerator, which lives as long as the program.
const char* to_string(Event::Kind kind);

}  // namespace sft
