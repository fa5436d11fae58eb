// expect: a_name_of_a_channel_has_a_character_and_neither_comma_nor_brace
#include "tests/compile_fail/cloud.h"

constexpr sft::Req<PointCloud2> declared = F::data.channels<"x,y">;
