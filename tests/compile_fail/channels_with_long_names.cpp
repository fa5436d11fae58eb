// expect: names_of_channels_are_too_long_together
#include "tests/compile_fail/cloud.h"

// The names, each followed by a comma, take 128 bytes, so there is no room for a NUL.
constexpr sft::Req<PointCloud2> declared =
    F::data.channels<"0123456789012345678901234567890123456789012345678901234567890123456789",
                     "01234567890123456789012345678901234567890123456789012345">;
