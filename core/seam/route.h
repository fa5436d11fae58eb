// The routes of a writer, and what a reader asks for and accepts.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/seam/address.h"
#include "core/seam/gate.h"
#include "sft/selection.h"

namespace sft::core {

/// Says where a reader is reached, and which samples and fields are sent to it. `selection` is closed, and
/// has no rate.
struct Route {
  EndpointId reader = 0;
  Locator destination;
  Selection selection;
  std::uint32_t min_period_us = 0;  ///< the maximum rate that the reader asks for, as a period; 0: none
  /// Enforces that rate and the conditions of the selection; null: every sample is for the reader.
  std::shared_ptr<const Gate> gate{};
  /// Not 0: the reader is served separately from all others, and this many retained samples are sent to it
  /// first.
  std::uint32_t history = 0;
  /// True: the reader is served in shared memory. This route is only for samples that shared memory could not
  /// take.
  bool fallback = false;
  bool reliable = false;  ///< samples that get lost on the way are sent again

  /// Returns true if the route has conditions, so that the reader does not want every sample that its rate
  /// allows.
  bool has_conditions() const { return gate != nullptr && gate->id() != 0; }
  friend bool operator==(const Route&, const Route&) = default;
};

/// The addresses of a writer's node. Answers to the writer are sent to no others.
struct Announced {
  bool known = false;  ///< false: no address is known; answers go to whatever address the datagrams name
  std::vector<UdpAddress> addresses{};
  bool same_network =
      false;  ///< the node is in the network of this process, so the loopback may reach it, too
  friend bool operator==(const Announced&, const Announced&) = default;
};

/// What a reader's port has to know of a writer whose samples the reader wants.
struct Source {
  EndpointId writer = 0;
  std::size_t max_sample_bytes = 0;
  /// The reader takes no samples of the writer before the retained samples, which are sent to it alone.
  bool history_first = false;
  bool reliable =
      false;           ///< samples are delivered in order, and those that get lost on the way are requested
  bool waits = false;  ///< its publisher waits for readers that do not keep up
  Announced node{};
  bool alive = true;  ///< its node answers
  friend bool operator==(const Source&, const Source&) = default;
};

/// The samples of a writer that are for one reader. (Several readers may share a destination.)
struct Wanted {
  Selection selection;  ///< closed, without a rate
  std::uint32_t min_period_us = 0;
  friend bool operator==(const Wanted&, const Wanted&) = default;
};

/// A request of a reader to its writers: the present one, or an earlier one while samples of it may be under
/// way.
struct Accepted {
  Wanted wanted;
  /// The number of the request, which grows with each, for readers that get samples in order. Once a writer
  /// has reported from which sample on it serves a request, later samples are for no earlier request. 0: not
  /// used.
  std::uint64_t request = 0;
  bool heard = false;  ///< each writer that was asked knows of the request by now
};

}  // namespace sft::core
