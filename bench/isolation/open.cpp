#include <utility>

#include "bench/isolation/contender.h"

namespace sft::bench::isolation {

std::unique_ptr<Writer> open_writer(const Contender& contender) {
  if (contender.middleware == Middleware::sft) return open_sft_writer(contender.reliable);
  if (contender.middleware == Middleware::cyclone) return open_cyclone_writer(contender.reliable);
  return open_fast_dds_writer(contender.reliable);
}

std::unique_ptr<Reader> open_reader(const Contender& contender, Place place, Arrived arrived) {
  if (contender.middleware == Middleware::sft)
    return open_sft_reader(contender.reliable, place, std::move(arrived));
  if (contender.middleware == Middleware::cyclone)
    return open_cyclone_reader(contender.reliable, std::move(arrived));
  return open_fast_dds_reader(contender.reliable, place, std::move(arrived));
}

}  // namespace sft::bench::isolation
