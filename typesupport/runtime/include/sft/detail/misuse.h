// Ends programs that would otherwise silently get wrong data, or corrupt their memory. Each function writes
// one line to the standard error, which says what to write instead, and calls std::abort(). Any thread may
// call these functions.
#pragma once

#include <string_view>

namespace sft {
struct Error;
}

namespace sft::detail {

[[noreturn, gnu::cold]] void stop_misuse(std::string_view what) noexcept;
/// Called if the program reads an empty sample. `type` is the name of the sample's type; empty if it is not
/// known.
[[noreturn, gnu::cold]] void stop_at_empty_sample(std::string_view type = {}) noexcept;
/// Called if the program reads a field that the sample was sent without.
[[noreturn, gnu::cold]] void stop_at_absent_field() noexcept;
/// Called if the program reads the value of a Result that has this error.
[[noreturn, gnu::cold]] void stop_at_error(const Error& error) noexcept;
/// Called if the program reads the error of a Result that has a value.
[[noreturn, gnu::cold]] void stop_at_missing_error() noexcept;

}  // namespace sft::detail
