// Copies a sample into memory that a transport lends. It is needed for samples that were made elsewhere,
// before shared memory was available, or while no chunk was free.
#pragma once

#include "core/seam/writer_port.h"

namespace sft::core {

/// Returns the copy. Empty if there is no memory for it now, or if the sample does not have all fields, which
/// readers in shared memory need. `sample` is one of `type`. The copy has room for `more_bytes` behind the
/// body.
SampleHandle copy_into(LendingWriter& memory, const SampleBuffer& sample, const TypeSupport& type,
                       std::size_t more_bytes = 0) noexcept;

}  // namespace sft::core
