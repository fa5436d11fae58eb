#include "bench/peers/entrant.h"

#include <algorithm>

namespace sft::bench::peers {

namespace {

struct Names {
  const char* name;
  const char* id;
};

Names names_of(Way way) {
  switch (way) {
    case Way::sft_two_fields:
      return {"SFT, two fields", "sft_two_fields"};
    case Way::sft_full:
      return {"SFT, full", "sft_full"};
    case Way::sft_loan:
      return {"SFT, full, loan", "sft_loan"};
    case Way::iceoryx:
      return {"iceoryx, copied", "iceoryx"};
    case Way::iceoryx_loan:
      return {"iceoryx, loan", "iceoryx_loan"};
    case Way::cyclone:
      return {"Cyclone DDS, UDP", "cyclone"};
    case Way::cyclone_iceoryx:
      return {"Cyclone DDS, iceoryx", "cyclone_iceoryx"};
    case Way::fast_dds:
      return {"Fast DDS, UDP", "fast_dds"};
    case Way::fast_dds_memory:
      return {"Fast DDS, memory", "fast_dds_memory"};
    case Way::tcp:
      return {"TCP", "tcp"};
    case Way::udp:
      return {"UDP", "udp"};
    case Way::memcpy_alone:
      break;
  }
  return {"memcpy alone", "memcpy"};
}

bool needs_one_host(Way way) {
  return way == Way::sft_loan || way == Way::iceoryx || way == Way::iceoryx_loan ||
         way == Way::cyclone_iceoryx || way == Way::fast_dds_memory;
}

}  // namespace

std::string name_of(const Entrant& entrant) {
  return names_of(entrant.way).name + std::string(entrant.spin_0 ? ", spin 0" : "");
}

std::string id_of(const Entrant& entrant) {
  return names_of(entrant.way).id + std::string(entrant.spin_0 ? "_spin0" : "");
}

bool can_spin(Way way) {
  return way != Way::cyclone && way != Way::cyclone_iceoryx && way != Way::fast_dds &&
         way != Way::fast_dds_memory && way != Way::memcpy_alone;
}

std::vector<Entrant> entrants(const Case& of) {
  std::vector<Entrant> all;
  for (int i = 0; i <= static_cast<int>(Way::memcpy_alone); ++i) {
    const Entrant entrant{static_cast<Way>(i)};
    if (of.where == Where::two_hosts && needs_one_host(entrant.way)) continue;
    if (of.readers > 1 && entrant.way == Way::memcpy_alone) continue;
    all.push_back(entrant);
    const bool tries_spin_0 = entrant.is_sft() && (of.readers == 1 || entrant.way == Way::sft_full);
    if (tries_spin_0 && of.waiting == Waiting::sleeping) all.push_back({entrant.way, true});
  }
  return all;
}

std::vector<Entrant> turns(std::vector<Entrant> all, std::size_t round) {
  if (!all.empty()) std::ranges::rotate(all, all.begin() + static_cast<std::ptrdiff_t>(round % all.size()));
  return all;
}

}  // namespace sft::bench::peers
