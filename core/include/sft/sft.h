// Everything a program needs, beside the headers generated for its message types.
#pragma once

#include "sft/domain.h"        // IWYU pragma: export
#include "sft/dynamic.h"       // IWYU pragma: export
#include "sft/event.h"         // IWYU pragma: export
#include "sft/node.h"          // IWYU pragma: export
#include "sft/options.h"       // IWYU pragma: export
#include "sft/publisher.h"     // IWYU pragma: export
#include "sft/qos.h"           // IWYU pragma: export
#include "sft/requirements.h"  // IWYU pragma: export
#include "sft/sample.h"        // IWYU pragma: export
#include "sft/snapshot.h"      // IWYU pragma: export
#include "sft/status.h"        // IWYU pragma: export
#include "sft/subscriber.h"    // IWYU pragma: export
#include "sft/time.h"          // IWYU pragma: export
#include "sft/topics.h"        // IWYU pragma: export
