#include "sft/detail/misuse.h"

#include <cstdio>
#include <cstdlib>
#include <string>

#include "sft/result.h"

namespace sft::detail {

void stop_misuse(std::string_view what) noexcept {
  std::fprintf(stderr, "sft: %.*s\n", static_cast<int>(what.size()), what.data());
  std::abort();
}

void stop_at_empty_sample(std::string_view type) noexcept {
  stop_misuse(
      "an empty sample" + (type.empty() ? "" : " of " + std::string(type)) +
      " is read: take() had nothing to give, or the sample was moved away; write `if (sample)` first");
}

void stop_at_absent_field() noexcept {
  stop_misuse(
      "a field is read that the sample was sent without: write `if (field)` first, where field is what the "
      "getter returns");
}

void stop_at_error(const Error& error) noexcept {
  stop_misuse("a result is read that is an error: " + error.message + "; write `if (result)` first");
}

void stop_at_missing_error() noexcept {
  stop_misuse("the error of a result is read that has a value; write `if (!result)` first");
}

}  // namespace sft::detail
