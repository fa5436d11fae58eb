// The result of a getter of a sample whose fields are recorded, or selected by text.
#pragma once

#include <optional>

namespace sft {

/// A field of such a sample: empty if the sample was sent without the field. It is a std::optional, and
/// converts to one, but its `*` gives the value itself and not a reference into the optional, so that
/// `for (auto f : *sample->fields())` does not iterate over a destroyed range. V is a number or a view:
/// small, and valid as long as the sample if it is a view. `*` and value() of an empty one are as those of
/// std::optional: undefined, and an exception.
template <class V>
class Optional : public std::optional<V> {
 public:
  using std::optional<V>::optional;
  /// The value itself. REQUIRES: there is one.
  V operator*() const { return std::optional<V>::operator*(); }
  /// The value itself. Throws std::bad_optional_access if there is none.
  V value() const { return std::optional<V>::value(); }
};

}  // namespace sft
