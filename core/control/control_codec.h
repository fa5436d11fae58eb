// Converts between the core's control structs and those that Cyclone's compiler made of sft_control.idl. What
// comes from outside is checked here.
#pragma once

#include <vector>

#include "core/control/control.h"
#include "core/control/control.h"
#include "sft/result.h"
#include "sft_control.h"

namespace sft::core {

/// Views into what is given and `storage`, valid as long as these; nothing is to be freed.
struct ControlStorage {
  std::vector<sft_control_Progress> progress;
  std::vector<sft_control_Account> accounts;
};
sft_control_Assertion to_dds(const Assertion& assertion, ControlStorage& storage);

Result<Assertion> from_dds(const sft_control_Assertion& assertion);

}  // namespace sft::core
