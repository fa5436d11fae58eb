// expect: names_of_channels_are_too_long_together
#include "tests/compile_fail/cloud.h"

// The names and a comma behind each of them take 128 bytes, which leave no room for a NUL.
constexpr sft::Req<PointCloud2> declared =
    F::data.channels<"0123456789012345678901234567890123456789012345678901234567890123456789",
                     "01234567890123456789012345678901234567890123456789012345">;
