// The fields and parts in a copy of a sample that serves several readers.
#pragma once

#include "sft/selection.h"

namespace sft::udp {

/// Returns what one copy has for the readers of both selections. If both are equal, it has just that.
/// Otherwise it has all their fields whole, and a reader of a part takes that out. The order of several
/// selections does not matter.
inline Selection one_copy(const Selection& a, const Selection& b) {
  return a == b ? a : Selection(a.mask() | b.mask());
}

/// Makes the copy `all` serve the selection `one`, too. `is_first`: the copy serves no selection yet.
inline void add_to_copy(Selection& all, const Selection& one, bool is_first) {
  all = is_first ? one : one_copy(all, one);
}

}  // namespace sft::udp
