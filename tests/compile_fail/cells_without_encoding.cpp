// expect: the declared mask lacks a field that the cells need: .*encoding
#include "tests/compile_fail/cloud.h"

constexpr sft::Mask<Image> declared = sft::all<Image> - Image::Field::encoding;

auto misuse(const sft::Sample<Image, declared>& sample) { return sample->data<std::uint8_t>(); }
