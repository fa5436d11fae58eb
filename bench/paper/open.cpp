#include "bench/paper/contender.h"

namespace sft::bench::paper {

std::unique_ptr<Peer> open(const Contender& contender) {
  if (contender.is_sft()) return open_sft(contender);
  return contender.way == Way::cyclone ? open_cyclone(contender) : open_fast_dds(contender);
}

}  // namespace sft::bench::paper
