// The result of a getter of a sample whose fields are recorded, or selected by text.
#pragma once

#include <optional>

#include "sft/detail/misuse.h"

namespace sft {

/// A field of a sample that may lack fields. It is empty if the sample was sent without the field. It is a
/// std::optional, and converts to one. But its `*` returns the value itself and not a reference into the
/// optional, so that `for (auto f : *sample->fields())` does not iterate over a destroyed range. V is a small
/// type, a number or a view. A view is valid as long as the sample. On an empty Optional `*` and `->` end the
/// program with a message; value() throws an exception, as on std::optional.
template <class V>
class Optional : public std::optional<V> {
 public:
  using std::optional<V>::optional;
  /// Returns the value itself. REQUIRES: the Optional has a value.
  V operator*() const { return *operator->(); }
  /// Gives access to the members of the value. REQUIRES: the Optional has a value.
  const V* operator->() const {
    if (!this->has_value()) [[unlikely]]
      detail::stop_at_absent_field();
    return std::optional<V>::operator->();
  }
  /// Returns the value itself. Throws std::bad_optional_access if there is no value.
  V value() const { return std::optional<V>::value(); }
};

}  // namespace sft
