// The check of `sft doctor` that compares the chunks of shared memory with the sizes that publishers of this
// host announce.
#pragma once

#include <sft/domain.h>

#include "tools/sft/finding.h"

namespace sft::tool {

Finding check_chunks(const DomainSnapshot& domain);

}  // namespace sft::tool
