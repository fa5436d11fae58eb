// Describes a subscriber's requirement to users (sft/requirements.h).
#pragma once

#include "core/subscribe/recorder.h"
#include "sft/requirements.h"
#include "sft/type_support.h"

namespace sft::core {

/// `requested` is the mask in force.
Requirements declared_requirements(const TypeSupport& type, const FieldMask& requested);
Requirements recorded_requirements(const TypeSupport& type, const FieldMask& requested,
                                   const Recorder& recorder);

}  // namespace sft::core
