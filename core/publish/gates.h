// The gates of one writer: one for each set of conditions and limit that its readers ask for, shared by all
// that ask for the same.
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

/// Used by the agent's thread. The gates themselves are used by the publisher's thread.
class Gates {
 public:
  /// `type` is the type of the writer's messages, and outlives this object.
  explicit Gates(const TypeSupport& type) : type_(type) {}

  /// Before routes are given theirs: lets go of gates that nobody has used for long, beyond a few. Until then
  /// they are kept: their numbers go on when somebody asks for the same again.
  void tidy();
  /// Gives each route the gate that its reader asks for, or none.
  void give(std::span<Route> routes);
  /// The gate that give() gave to the route.
  const std::shared_ptr<Gate>& of(const Route& route) const;
  /// The routes are in force: there is no earlier sample for those readers that have asked for something else
  /// before, or for nothing.
  void open_for(const Serving& serving);

 private:
  struct Entry {
    std::uint32_t min_period_us = 0;
    std::vector<Selection::Condition> conditions{};
    std::shared_ptr<Gate> gate{};
  };
  /// The gate and the selection of a reader.
  using Asked = std::pair<const Gate*, std::uint64_t>;

  std::shared_ptr<Gate>& find(const Route& route);

  const TypeSupport& type_;
  std::vector<Entry> gates_;
  std::map<EndpointId, Asked> asked_;  ///< of readers behind gates with conditions
};

}  // namespace sft::core
