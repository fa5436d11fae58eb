// A sample that was made elsewhere, in memory that a transport lends: before shared memory came up, or while
// it had no chunk free.
#pragma once

#include "core/seam/writer_port.h"

namespace sft::core {

/// Empty if there is no memory for it now, or if the sample does not have all fields, as readers in shared
/// memory need them. `sample` is one of `type`. The memory has room for so many bytes more.
SampleHandle copy_into(LendingWriter& memory, const SampleBuffer& sample, const TypeSupport& type,
                       std::size_t more_bytes = 0) noexcept;

}  // namespace sft::core
