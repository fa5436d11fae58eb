// A part of a program that is compiled with -fno-exceptions and -fno-rtti.
#pragma once

#include "sft/result.h"

namespace sft::test {

/// Returns result.value(), or ends the program.
int value_without_exceptions(const Result<int>& result);

}  // namespace sft::test
