// The number of samples per second that pass each gate of a writer. A gate withholds samples because of a
// maximum rate or of conditions (core::Gate).
#pragma once

#include <map>
#include <memory>

#include "core/seam/gate.h"
#include "udp_transport/multicast/sample_rate.h"

namespace sft::udp {

class PassRates {
 public:
  using Time = PassRate::Time;

  /// Begins to count the samples that pass the gate, unless they are counted already.
  void follow(const std::shared_ptr<const core::Gate>& gate, Time now) {
    rates_.try_emplace(gate, now, gate->passed());
  }
  /// Removes gates that only this object still refers to.
  void forget_unused() {
    std::erase_if(rates_, [](const auto& item) { return item.first.use_count() == 1; });
  }
  /// Returns the rate of samples that pass the gate. REQUIRES: the gate is followed (follow()).
  double per_s(const std::shared_ptr<const core::Gate>& gate, Time now) {
    return rates_.at(gate).per_s(now, gate->passed());
  }

 private:
  std::map<std::shared_ptr<const core::Gate>, PassRate> rates_;
};

}  // namespace sft::udp
