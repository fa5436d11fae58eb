#include "bench/paper/lower_bound.h"

#include <algorithm>

namespace sft::bench::paper {

std::size_t least_bytes(std::size_t cdr_bytes) {
  constexpr std::size_t frame_headers = 14 + 20 + 8;
  constexpr std::size_t frame_payload_max = 1500 - 20 - 8;
  const std::size_t frames =
      std::max<std::size_t>(1, (cdr_bytes + frame_payload_max - 1) / frame_payload_max);
  return cdr_bytes + frames * frame_headers;
}

}  // namespace sft::bench::paper
