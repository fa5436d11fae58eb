#include "bench/peers/entrant.h"

#include <algorithm>
#include <array>

namespace sft::bench::peers {

namespace {

/// The properties of each value of Way, in the same order.
struct Facts {
  const char* name;
  const char* id;
  bool needs_one_host = false;
};

constexpr std::array facts{Facts{"SFT, two fields", "sft_two_fields"},
                           Facts{"SFT, full", "sft_full"},
                           Facts{"SFT, full, loan", "sft_loan", true},
                           Facts{"iceoryx, copied", "iceoryx", true},
                           Facts{"iceoryx, loan", "iceoryx_loan", true},
                           Facts{"Cyclone DDS, UDP", "cyclone"},
                           Facts{"Cyclone DDS, iceoryx", "cyclone_iceoryx", true},
                           Facts{"Fast DDS, UDP", "fast_dds"},
                           Facts{"Fast DDS, memory", "fast_dds_memory", true},
                           Facts{"TCP", "tcp"},
                           Facts{"UDP", "udp"},
                           Facts{"memcpy alone", "memcpy"}};

const Facts& facts_of(Way way) { return facts[static_cast<std::size_t>(way)]; }

}  // namespace

std::string name_of(const Entrant& entrant) {
  return facts_of(entrant.way).name + std::string(entrant.spin_0 ? ", spin 0" : "");
}

std::string id_of(const Entrant& entrant) {
  return facts_of(entrant.way).id + std::string(entrant.spin_0 ? "_spin0" : "");
}

std::vector<Entrant> entrants(const Case& of) {
  std::vector<Entrant> all;
  for (int i = 0; i <= static_cast<int>(Way::memcpy_alone); ++i) {
    const Entrant entrant{static_cast<Way>(i)};
    if (of.where == Where::two_hosts && facts_of(entrant.way).needs_one_host) continue;
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
