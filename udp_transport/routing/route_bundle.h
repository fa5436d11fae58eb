// Routes put together: readers with equal masks and limits share an encoding, and those behind one socket a
// copy of it.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/seam/transport.h"
#include "udp_transport/flow/destination.h"
#include "udp_transport/reliable/channel_directory.h"

namespace sft::udp {

struct Gathered {
  core::Wanted wanted;
  core::EndpointId late_reader = 0;
  bool spare = false;
  std::shared_ptr<const core::RateGate> gate{};
  std::vector<std::shared_ptr<Destination>> destinations{};
  std::vector<std::pair<core::EndpointId, const Destination*>> readers{};
  ReliableReaders reliable{};              ///< of these
  std::optional<std::size_t> multicast{};  ///< the place of the group that sends it to all of them

  void add(const std::shared_ptr<Destination>& to);
};

/// Routes to readers elsewhere than behind a UDP address are left out. Spare ones come last.
std::vector<Gathered> gather(std::span<const core::Route> routes, DestinationDirectory& directory);

}  // namespace sft::udp
