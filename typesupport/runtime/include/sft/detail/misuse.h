// Ends programs that do what would give them wrong data, or break their memory, without a word. Each function
// writes one line to the standard error, which says what to write instead, and calls std::abort(). Any
// thread.
#pragma once

#include <string_view>

namespace sft::detail {

[[noreturn, gnu::cold]] void stop_misuse(std::string_view what) noexcept;
/// An empty sample of this type is read, which is empty if it is not known.
[[noreturn, gnu::cold]] void stop_at_empty_sample(std::string_view type = {}) noexcept;
/// A field is read that the sample was sent without.
[[noreturn, gnu::cold]] void stop_at_absent_field() noexcept;

}  // namespace sft::detail
