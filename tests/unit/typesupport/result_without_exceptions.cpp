#include "tests/unit/typesupport/result_without_exceptions.h"

namespace sft::test {
namespace {

/// A Result of this type has no value() that was compiled with exceptions.
struct Number {
  int value;
};

}  // namespace

int value_without_exceptions(const Result<int>& result) {
  return result.map([](int value) { return Number{value}; }).value().value;
}

}  // namespace sft::test
