// expect: (this_field_is_not_declared::name_it_where_the_subscriber_is_opened .*::data[(]|call to deleted
// .*'data') expect: this_field_is_not_declared
#include "tests/compile_fail/cloud.h"

auto misuse(const sft::Sample<Image, Image::Field::height>& sample) { return sample->data<std::uint8_t>(); }
