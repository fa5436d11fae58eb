// Outlets say where the samples of a publisher are sent, and which fields each sample needs for these
// destinations. They are derived from the desired state of the negotiation, for the publisher's thread.
// Outlets that are in force are never modified, but replaced.
#pragma once

#include <memory>
#include <vector>

#include "core/negotiation/serving.h"
#include "core/publish/gates.h"
#include "core/seam/delivery.h"
#include "core/seam/transport.h"
#include "core/seam/vanilla_port.h"
#include "sft/type_support.h"

namespace sft::core {

struct Outlets {
  /// Readers in shared memory that share a gate.
  struct MemoryGroup {
    std::shared_ptr<const Gate> gate;
    std::shared_ptr<DeliveryTally> tally;
    /// True: samples that shared memory does not take can be sent to these readers over the network.
    bool have_fallback;
    bool wants_sample() const { return gate == nullptr || gate->passes(); }
  };

  std::shared_ptr<LendingWriter> memory;  ///< null while there is no shared memory
  std::shared_ptr<VanillaPort> vanilla;   ///< null while no unmodified DDS reader is served
  bool is_wanted = false;                 ///< true: samples must be made, because there is a reader or the
                                          ///< publisher retains samples
  bool to_memory = false;
  bool to_network = false;
  bool has_fallback = false;                 ///< some of `memory_groups` have a fallback
  std::vector<std::shared_ptr<Gate>> gates;  ///< the gates that must decide about each sample
  /// True: a reliable reader in shared memory has no fallback route over the network.
  bool needs_memory = false;
  bool to_all = false;  ///< at least one reader gets every sample
  FieldMask mask;       ///< the fields to encode: all for shared memory, otherwise the union of all requests
  bool whole = false;   ///< `mask` has all fields
  std::vector<MemoryGroup> memory_groups;
  /// The gates in `gates` that the gate tables of samples contain.
  std::vector<std::shared_ptr<Gate>> memory_gates;
  DeliveryBook::Page page;  ///< the assignment of delivery counts to the readers of these outlets
                            ///< (delivery.h)

  /// Returns true if samples that are made for these outlets have all that the routes of `other` need.
  bool provides_for(const Outlets& other) const;
  /// Returns these outlets with the fields and gates of `other` added.
  Outlets with(const Outlets& other) const;
};

/// The ports that a publisher may use, and whether it retains samples.
struct Means {
  std::shared_ptr<LendingWriter> memory;  ///< null while there is no shared memory
  bool network = false;                   ///< the publisher may use the network
  std::shared_ptr<VanillaPort> vanilla;   ///< null while no unmodified DDS reader is served
  bool retains = false;  ///< the publisher retains samples; late readers may request any field of them
};

/// Makes the outlets for `serving`. REQUIRES: each route in `serving` has got its gate from `gates`.
std::shared_ptr<Outlets> make_outlets(const TypeSupport& type, const Serving& serving, const Gates& gates,
                                      Means means);

}  // namespace sft::core
