// expect: fields of two message types in one mask
#include "tests/compile_fail/cloud.h"

auto misuse() { return F::height == Image::Field::height; }
