// Describes a subscriber's requirement to users (sft/requirements.h).
#pragma once

#include "core/subscribe/recorder.h"
#include "sft/requirements.h"
#include "sft/type_support.h"

namespace sft::core {

/// These functions describe a requirement. `requested` is the request in force.
Requirements declared_requirements(const TypeSupport& type, const Selection& requested);
Requirements recorded_requirements(const TypeSupport& type, const Selection& requested,
                                   const Recorder& recorder);

}  // namespace sft::core
