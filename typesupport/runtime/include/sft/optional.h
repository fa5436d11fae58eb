// The result of a getter of a sample whose fields are recorded, or selected by text.
#pragma once

#include <optional>

namespace sft {

/// A field of such a sample: empty if the sample was sent without the field. It is a std::optional, and
/// converts to one. But its `*` returns the value itself and not a reference into the optional, so that `for
/// (auto f : *sample->fields())` does not iterate over a destroyed range. V is a small type, a number or a
/// view. A view is valid as long as the sample. On an empty Optional `*` is undefined and value() throws, as
/// on std::optional.
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
