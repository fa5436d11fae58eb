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

/// A reader to be served, and with what. `selection` is closed, and has no rate.
struct Route {
  EndpointId reader = 0;
  Locator destination;
  Selection selection;
  std::uint32_t min_period_us = 0;  ///< the limit that the reader asks for; 0: none
  /// Keeps that limit and the conditions of the selection; null: every sample is for the reader.
  std::shared_ptr<const Gate> gate{};
  /// Not 0: the reader is served apart from all others, and is sent this many retained samples first.
  std::uint32_t history = 0;
  /// The reader is served elsewhere: this route is for samples that are sent by fallback routes, too.
  bool fallback = false;
  bool reliable = false;  ///< what gets lost on the way is sent again

  /// True if the reader does not want every sample that its rate lets pass.
  bool has_conditions() const { return gate != nullptr && gate->id() != 0; }
  friend bool operator==(const Route&, const Route&) = default;
};

/// The addresses of a writer's node. Nobody else is answered in its name.
struct Announced {
  bool known = false;  ///< false: nothing is known of it, and it is answered wherever it says
  std::vector<UdpAddress> addresses{};
  bool same_network = false;  ///< as this process: it may be reached by loopback, too
  friend bool operator==(const Announced&, const Announced&) = default;
};

/// The facts that a reader has to know of a writer whose samples it wants.
struct Source {
  EndpointId writer = 0;
  std::size_t max_sample_bytes = 0;
  bool history_first =
      false;              ///< the reader takes nothing of it before samples for this reader alone have come
  bool reliable = false;  ///< in order, and what gets lost on the way is asked for
  bool waits = false;     ///< its publisher waits for readers that do not keep up
  Announced node{};
  bool alive = true;  ///< its node answers
  friend bool operator==(const Source&, const Source&) = default;
};

/// The samples of a writer that are for one reader, where several readers share a destination.
struct Wanted {
  Selection selection;  ///< closed, without a rate
  std::uint32_t min_period_us = 0;
  friend bool operator==(const Wanted&, const Wanted&) = default;
};

/// A request of a reader to its writers: the present one, or an earlier one while samples may be under way
/// under it.
struct Accepted {
  Wanted wanted;
  /// Counts up, for readers that get samples in order: once a writer has told how far it was when it knew of
  /// a request, what comes behind that is under no earlier one. 0: nobody relies on that.
  std::uint64_t request = 0;
  bool heard = false;  ///< each writer that was asked knows of it by now
};

}  // namespace sft::core
