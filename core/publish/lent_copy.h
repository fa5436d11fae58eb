// Copies a sample into memory that a transport lends. A copy is needed for samples that were made in other
// memory, before shared memory was available or while no chunk was free.
#pragma once

#include "core/seam/writer_port.h"

namespace sft::core {

/// Returns the copy. The handle is empty if no memory is free at present, or if the sample lacks fields,
/// since readers in shared memory need all fields. `type` is the type of the sample. The memory of the copy
/// has `more_bytes` free bytes after the body.
SampleHandle copy_into(LendingWriter& memory, const SampleBuffer& sample, const TypeSupport& type,
                       std::size_t more_bytes = 0) noexcept;

}  // namespace sft::core
