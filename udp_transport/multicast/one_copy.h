// The fields and parts in a copy of a sample that serves several readers.
#pragma once

#include "sft/selection.h"

namespace sft::udp {

/// Returns the content of one copy for the readers of both selections. If the selections are equal, the copy
/// has exactly that content. Otherwise the copy has all fields of both as whole fields, and a reader of a
/// part extracts that part. The order in which several selections are combined does not matter.
inline Selection one_copy(const Selection& a, const Selection& b) {
  return a == b ? a : Selection(a.mask() | b.mask());
}

/// Extends the copy `all` so that it serves the selection `one`, too. `is_first` is true if the copy serves
/// no selection yet.
inline void add_to_copy(Selection& all, const Selection& one, bool is_first) {
  all = is_first ? one : one_copy(all, one);
}

}  // namespace sft::udp
