// The gates of one writer: one for each combination of conditions and maximum rate that its readers ask for.
// Readers that ask for the same combination share a gate.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "core/negotiation/serving.h"
#include "core/seam/gate.h"
#include "core/seam/transport.h"
#include "sft/type_support.h"

namespace sft::core {

/// Used by the agent's thread. The publisher's thread uses only the gates that it contains.
class Gates {
 public:
  /// `type` is the type of the writer's messages. It must outlive this object.
  explicit Gates(const TypeSupport& type) : type_(type) {}

  /// Removes unused gates if there are more than a few. Must be called before give(). Unused gates are kept
  /// for a while, so that their ordinals continue if a reader requests the same combination again.
  void tidy();
  /// Gives each route the gate for the combination that its reader requests. A route without a maximum rate
  /// and conditions gets none.
  void give(std::span<Route> routes);
  /// Returns the gate that give() has assigned to the route.
  const std::shared_ptr<Gate>& of(const Route& route) const;
  /// Called when the routes are in force. For readers whose gate or selection is new, the next sample is not
  /// compared with earlier samples (Gate::reader_begins()).
  void open_for(const Serving& serving);

 private:
  struct Entry {
    std::uint32_t min_period_us = 0;
    std::vector<Selection::Condition> conditions{};
    std::shared_ptr<Gate> gate{};
  };
  /// The gate of a reader, and the hash of the reader's selection.
  using Asked = std::pair<const Gate*, std::uint64_t>;

  std::shared_ptr<Gate>& find(const Route& route);

  const TypeSupport& type_;
  std::vector<Entry> gates_;
  std::map<EndpointId, Asked> asked_;  ///< the present gate of each reader whose gate has conditions
};

}  // namespace sft::core
