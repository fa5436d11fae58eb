#include "bench/isolation/contender.h"

namespace sft::bench::isolation {

std::string name_of(Middleware middleware) {
  switch (middleware) {
    case Middleware::sft:
      return "SFT";
    case Middleware::cyclone:
      return "Cyclone DDS";
    case Middleware::fast_dds:
      break;
  }
  return "Fast DDS";
}

std::string name_of(const Contender& contender) {
  return name_of(contender.middleware) + (contender.reliable ? ", reliable" : ", best effort");
}

}  // namespace sft::bench::isolation
