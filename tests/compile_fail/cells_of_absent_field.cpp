// expect: this_field_is_not_declared::name_it_.*::data[(]|call to deleted
// expect: this_field_is_not_declared
#include "tests/compile_fail/cloud.h"

auto misuse(const sft::Sample<Image, Image::Field::height>& sample) { return sample->data<std::uint8_t>(); }
