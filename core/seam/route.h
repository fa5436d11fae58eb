// The routes of a writer, and the requests of a reader.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/seam/address.h"
#include "core/seam/gate.h"
#include "sft/selection.h"

namespace sft::core {

/// The destination of a reader, and the samples and fields that are sent to the reader. `selection` is
/// closed, and has no rate.
struct Route {
  EndpointId reader = 0;
  Locator destination;
  Selection selection;
  /// The minimum time between two samples in microseconds, according to the maximum rate that the reader
  /// requests; 0: no limit.
  std::uint32_t min_period_us = 0;
  /// Enforces the rate and the conditions of the selection; null: the reader gets every sample.
  std::shared_ptr<const Gate> gate{};
  /// Not 0: the reader is served separately from all others, and this number of retained samples is sent to
  /// it first.
  std::uint32_t history = 0;
  /// True: the reader is served in shared memory, and this route is used only for samples that shared
  /// memory could not take.
  bool fallback = false;
  bool reliable = false;  ///< true: samples that are lost on the way are sent again

  /// Returns true if the route has conditions. Then the reader may not want every sample that its maximum
  /// rate allows.
  bool has_conditions() const { return gate != nullptr && gate->id() != 0; }
  friend bool operator==(const Route&, const Route&) = default;
};

/// The addresses of a writer's node. Answers to the writer are sent to no other addresses.
struct Announced {
  /// False: no address is known, and answers are sent to the source addresses of the datagrams.
  bool known = false;
  std::vector<UdpAddress> addresses{};
  /// True: the node is in the network of this process, so that the loopback may reach it, too.
  bool same_network = false;
  friend bool operator==(const Announced&, const Announced&) = default;
};

/// A writer whose samples a reader wants, as the port of the reader needs to know it.
struct Source {
  EndpointId writer = 0;
  std::size_t max_sample_bytes = 0;
  /// True: the reader takes no other samples of the writer before the retained samples, which are sent to it
  /// alone.
  bool history_first = false;
  /// True: samples are delivered in order, and samples that are lost on the way are requested again.
  bool reliable = false;
  bool waits = false;  ///< true: the publisher waits for readers that do not keep up
  Announced node{};
  bool alive = true;  ///< true: the writer's node answers
  friend bool operator==(const Source&, const Source&) = default;
};

/// The samples of a writer that are for one reader. (Several readers may share a destination.)
struct Wanted {
  Selection selection;  ///< the selection, which is closed and has no rate
  std::uint32_t min_period_us = 0;
  friend bool operator==(const Wanted&, const Wanted&) = default;
};

/// A request of a reader to its writers: the present request, or an earlier one while samples for it may be
/// under way.
struct Accepted {
  Wanted wanted;
  /// The number of the request, which grows with each request. It is used for readers that get samples in
  /// order. Once a writer has reported the first sample for which a request is in force, that sample and
  /// later ones are not delivered for earlier requests. 0: not used.
  std::uint64_t request = 0;
  bool heard = false;  ///< true: each writer that was asked has received the request in the meantime
};

}  // namespace sft::core
