// expect: no matching (member )?function for call to .*data
// expect: field_is_in_declared_mask
#include "tests/compile_fail/cloud.h"

auto misuse(const sft::Sample<Image, Image::Field::height>& sample) { return sample->data<std::uint8_t>(); }
