// The fields and parts in a copy of a sample that serves several readers.
#pragma once

#include "sft/selection.h"

namespace sft::udp {

/// Returns what one copy has for readers of both: just that part if both ask for the same, and all their
/// fields whole otherwise, from which whoever asked for a part takes it. The order of several does not
/// matter.
inline Selection one_copy(const Selection& a, const Selection& b) {
  return a == b ? a : Selection(a.mask() | b.mask());
}

/// Makes `all` serve this one, too. `is_first`: it serves nobody yet.
inline void add_to_copy(Selection& all, const Selection& one, bool is_first) {
  all = is_first ? one : one_copy(all, one);
}

}  // namespace sft::udp
