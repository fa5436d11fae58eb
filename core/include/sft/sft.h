// All public headers: everything that a program needs in addition to the headers that are generated for its
// message types. Headers in sft/detail/ and names in sft::detail are for generated code and for SFT's own
// libraries. They may change with every version.
#pragma once

#include "sft/cells.h"         // IWYU pragma: export
#include "sft/domain.h"        // IWYU pragma: export
#include "sft/dynamic.h"       // IWYU pragma: export
#include "sft/dynamic_type.h"  // IWYU pragma: export
#include "sft/dynamic_view.h"  // IWYU pragma: export
#include "sft/event.h"         // IWYU pragma: export
#include "sft/json.h"          // IWYU pragma: export
#include "sft/mask.h"          // IWYU pragma: export
#include "sft/msg_text.h"      // IWYU pragma: export
#include "sft/node.h"          // IWYU pragma: export
#include "sft/optional.h"      // IWYU pragma: export
#include "sft/options.h"       // IWYU pragma: export
#include "sft/points.h"        // IWYU pragma: export
#include "sft/publisher.h"     // IWYU pragma: export
#include "sft/qos.h"           // IWYU pragma: export
#include "sft/requirements.h"  // IWYU pragma: export
#include "sft/result.h"        // IWYU pragma: export
#include "sft/sample.h"        // IWYU pragma: export
#include "sft/sample_info.h"   // IWYU pragma: export
#include "sft/selection.h"     // IWYU pragma: export
#include "sft/service.h"       // IWYU pragma: export
#include "sft/snapshot.h"      // IWYU pragma: export
#include "sft/status.h"        // IWYU pragma: export
#include "sft/strides.h"       // IWYU pragma: export
#include "sft/subscriber.h"    // IWYU pragma: export
#include "sft/time.h"          // IWYU pragma: export
#include "sft/type.h"          // IWYU pragma: export
#include "sft/type_support.h"  // IWYU pragma: export
#include "sft/yaml.h"          // IWYU pragma: export
