// expect: the declared mask lacks a field that the cells need: add the numbers of rows and columns
#include "tests/compile_fail/cloud.h"

using Rgb = std::array<std::uint8_t, 3>;

auto misuse(const sft::Sample<Image, Image::Field::data>& sample) { return sample->data<Rgb>(); }
