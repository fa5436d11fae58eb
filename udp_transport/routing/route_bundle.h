// Groups routes into bundles. Readers with equal masks and limits share an encoding of each sample. Readers
// of one socket share a copy of that encoding.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/seam/transport.h"
#include "udp_transport/flow/destination.h"
#include "udp_transport/flow/destination_directory.h"
#include "udp_transport/reliable/channel_directory.h"

namespace sft::udp {

struct RouteBundle {
  core::Wanted wanted;
  core::EndpointId late_reader = 0;
  bool fallback = false;
  std::shared_ptr<const core::Gate> gate{};
  std::vector<std::shared_ptr<Destination>> destinations{};
  std::vector<std::pair<core::EndpointId, const Destination*>> readers{};
  ReliableReaders reliable{};  ///< the readers that are served reliably
  /// The index of the multicast group that sends to all destinations; empty if no group does.
  std::optional<std::size_t> multicast{};
  /// True if the readers may have different requests; then `wanted` is one_copy() for all of them.
  bool merged = false;

  void add(const std::shared_ptr<Destination>& to);
  void absorb(RouteBundle other);
  /// Returns true if the readers do not get exactly the published samples, because they have a gate,
  /// retained samples, or a fallback route.
  bool is_for_some_samples() const {
    return gate != nullptr || late_reader != 0 || fallback || !wanted.selection.gate().is_open();
  }
};

/// Returns the bundles of the routes. Routes that do not lead to a UDP address are omitted. Fallback bundles
/// come last.
std::vector<RouteBundle> bundle_routes(std::span<const core::Route> routes, DestinationDirectory& directory);

/// Removes the destinations for which `is_one` returns true from all bundles that are not merged, and
/// returns them as one merged bundle. Some bundles may have no destinations afterwards. REQUIRES: all
/// readers at these destinations get the same samples.
RouteBundle take_out(std::vector<RouteBundle>& routes, const std::function<bool(const Destination*)>& is_one);

}  // namespace sft::udp
