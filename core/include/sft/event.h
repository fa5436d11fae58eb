// What publishers and subscribers tell of by themselves, so that nobody needs to poll status().
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "sft/qos.h"

namespace sft {

enum class EventKind : std::uint8_t {
  matched,               ///< `text`: by which path, and why
  unmatched,             ///< `text`: why
  path_changed,          ///< `text`: to which, and why
  incompatible_qos,      ///< `policy`; never matches
  incompatible_type,     ///< the same name of a topic, another type; never matches
  no_path,               ///< all fits but the ways that both may use; `text`: why there is none
  deadline_missed,       ///< offered, on a publisher: `peer` is 0; requested, on a subscriber
  liveliness_lost,       ///< on a publisher, its own: `peer` is 0; on a subscriber, that of a publisher
  liveliness_recovered,  ///< likewise
  samples_lost,          ///< on subscribers
  samples_diverted,      ///< on publishers: by UDP, since shared memory could not take them; `text`: why
  held_too_many,  ///< on subscribers: as many samples as they may, and take() gives no more; `peer` is 0
  /// A subscriber asks for other fields or another rate, which `text` names; on the subscriber itself `peer`
  /// is 0.
  request_changed,
};
const char* to_string(EventKind kind);

/// What has happened to a publisher, a subscriber or a pair of both.
struct Event {
  /// What has happened.
  EventKind kind{};
  std::uint64_t peer = 0;  ///< id of the subscriber or publisher at the other end; 0: concerns none
  std::string node{};      ///< and its node
  /// Of incompatible_qos: the first policy that does not fit.
  QosPolicy policy = QosPolicy::none;
  std::uint64_t count = 1;  ///< of deadlines missed, samples lost or diverted since the last such event
  bool yet = false;         ///< of no_path: shared memory may still come up, here or there
  bool reliable = false;    ///< of samples_lost: the subscriber asked for reliability
  std::string text{};       ///< for people
  friend bool operator==(const Event&, const Event&) = default;
};

/// Called on the node's agent thread, which does nothing else meanwhile: be short. If it holds that up for a
/// few seconds (5, or 14 with peers or without multicast), other nodes take this one for dead and serve it no
/// more until it goes on. No lock is held, everything of SFT may be called and destroyed. The node's log gets
/// the same, whether there is a callback or not. What comes and goes within one batch of news may not be
/// told. After the destructor of the publisher or subscriber it is not called any more (unless that runs in
/// the call itself).
using EventCallback = std::function<void(const Event&)>;

}  // namespace sft
