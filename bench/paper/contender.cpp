#include "bench/paper/contender.h"

namespace sft::bench::paper {

std::string name_of(Way way) {
  switch (way) {
    case Way::sft_recorded:
      return "SFT, recorded";
    case Way::sft_declared:
      return "SFT, declared";
    case Way::sft_full:
      return "SFT, all fields";
    case Way::cyclone:
      return "Cyclone DDS";
    case Way::fast_dds:
      break;
  }
  return "Fast DDS";
}

std::string name_of(const Contender& contender) {
  return name_of(contender.way) + (contender.reliable ? ", reliable" : ", best effort") +
         (contender.multicast ? ", multicast" : ", unicast");
}

std::vector<Contender> all_contenders() {
  std::vector<Contender> all;
  for (const Way way : {Way::sft_recorded, Way::sft_declared, Way::sft_full, Way::cyclone, Way::fast_dds}) {
    for (const bool reliable : {false, true}) {
      for (const bool multicast : {false, true}) all.push_back({way, reliable, multicast});
    }
  }
  return all;
}

Contender idle_twin(const Contender& contender) {
  return {contender.is_sft() ? Way::sft_full : contender.way, false, contender.multicast};
}

}  // namespace sft::bench::paper
